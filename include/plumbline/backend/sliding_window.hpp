#pragma once
/// Backend policy: a window of K frames (backend/window_backend.hpp). FrontEndPolicy names the front end of each kind,
/// FactorTypes the factors that can be attached to frames:
///
///   SlidingWindow<10>                           optical flow
///   SlidingWindow<10, Flow, AbsolutePosition>   with positions from outside

#include "plumbline/backend/window_backend.hpp"
#include "plumbline/factor/frame_factors.hpp"
#include "plumbline/frontend/flow.hpp"
#include "plumbline/propagation/propagation.hpp"

namespace plumbline {

template <int K, class FrontEndPolicy = Flow, template <class> class... FactorTypes>
struct SlidingWindow {
  static_assert(K >= 3, "plumbline: a window needs at least three keyframes");
  static constexpr int slots = K;
  using FrontEnds = FrontEndPolicy;

  template <Propagation PropagationT, class Landmarks>
  using Backend =
      WindowBackend<PropagationT, Landmarks, K, FrameFactorsOf<typename PropagationT::S, K, FactorTypes...>>;
};

}  // namespace plumbline
