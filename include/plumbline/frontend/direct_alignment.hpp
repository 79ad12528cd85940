#pragma once
/// Front-end policy: the frame's pose from the pixels of all landmarks together, then each by itself; a kind of one's
/// own by the front end that it brings, as in Flow.                                              docs/math/direct.md

#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/frontend/direct_lines.hpp"
#include "plumbline/frontend/direct_points.hpp"
#include "plumbline/frontend/flow.hpp"
#include "plumbline/frontend/image_motion.hpp"

namespace plumbline {

namespace detail {
template <class Entry, class Store>
struct DirectOf : FlowOf<Entry, Store> {};
template <int N, template <class> class Loss, class Store>
struct DirectOf<Points<N, Loss>, Store> {
  using Type = DirectPoints<Store>;
};
template <int N, class Detector, template <class> class Loss, class Store>
struct DirectOf<Lines<N, Detector, Loss>, Store> {
  using Type = DirectLines<Store, Detector>;
};
}  // namespace detail

struct DirectAlignment {
  template <class Entry, class Store>
  using Of = typename detail::DirectOf<Entry, Store>::Type;
  template <class Sensors, int MaxSamples>
  using Motion = ImageMotion<Sensors, MaxSamples>;
};

}  // namespace plumbline
