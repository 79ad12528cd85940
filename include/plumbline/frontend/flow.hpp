#pragma once
/// Front-end policy of tracking from image to image: points by optical flow, lines by their edges or by the points on
/// them. A kind defined by the user brings its own front end (`template <class Store> using FrontEnd`).

#include "plumbline/feature/collinear.hpp"
#include "plumbline/feature/initialization_points.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/frontend/collinear_segments.hpp"
#include "plumbline/frontend/edge_following.hpp"
#include "plumbline/frontend/initialization_flow.hpp"
#include "plumbline/frontend/point_flow.hpp"

namespace plumbline {

namespace detail {
template <class Entry, class Store>
struct FlowOf {
  using Type = typename Entry::template FrontEnd<Store>;
};
template <int N, template <class> class Loss, class Store>
struct FlowOf<Points<N, Loss>, Store> {
  using Type = PointFlow<Store>;
};
template <int N, template <class> class Loss, class Store>
struct FlowOf<InitializationPoints<N, Loss>, Store> {
  using Type = InitializationFlow<Store>;
};
template <int N, class Detector, template <class> class Loss, class Store>
struct FlowOf<Lines<N, Detector, Loss>, Store> {
  using Type = EdgeFollowing<Store, Detector>;
};
template <int N, class Detector, template <class> class Loss, class Store>
struct FlowOf<Collinear<N, Detector, Loss>, Store> {
  using Type = CollinearSegments<Store, Detector>;
};
}  // namespace detail

struct Flow {
  template <class Entry, class Store>
  using Of = typename detail::FlowOf<Entry, Store>::Type;
};

}  // namespace plumbline
