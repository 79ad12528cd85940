#pragma once
/// Front-end policy of direct tracking: the pose of a frame from the intensities of patches of all landmarks, then
/// feature alignment of each one. A kind without a direct front end uses that of Flow.              docs/math/direct.md

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
