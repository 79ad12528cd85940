#pragma once
// Observations as residuals of plumbline/residual/, each with its whitening and its kernel: what the rows of every kind
// are made of.

#include "plumbline/feature/line_kind.hpp"
#include "plumbline/feature/point_kind.hpp"
#include "plumbline/residual/anchored_line.hpp"
#include "plumbline/residual/inverse_depth_point.hpp"
#include "plumbline/residual/world_line.hpp"
#include "plumbline/residual/world_point.hpp"

namespace plumbline::test {

/// Gives visit(linearization, L, kernel) of what another frame than the anchor measured.
template <class Sensors, class S>
void for_each_view_residual(PointKind<Sensors>, const Sensors& rig, const typename PointKind<Sensors>::Geometry& point,
                            const typename PointKind<Sensors>::Observation& seen, const RelativeView<S>& view,
                            auto&& visit) {
  using Camera = typename Sensors::Camera;
  const InverseDepthReprojection<Camera> pixel{seen.uv.template cast<S>()};
  visit(pixel.linearize(rig.vision.camera, view, point.bearing, point.inverse_range),
        Mat<S, 2, 2>(seen.L.template cast<S>()), Huber<S>{S(2.45)});
  const InverseDepth<S> depth = seen.depth.get();
  if (!depth.valid) return;
  visit(InverseDepthMeasurement<S>{depth.value}.linearize(view, point.bearing, point.inverse_range),
        Mat<S, 1, 1>(1 / depth.sigma), Huber<S>{S(1.345)});
}
template <class Sensors, class S>
void for_each_view_residual(LineKind<Sensors>, const Sensors&, const LineGeometry<S>& line,
                            const typename LineKind<Sensors>::Observation& seen, const RelativeView<S>& view,
                            auto&& visit) {
  const Huber<S> loss{S(2.45)};
  visit(AnchoredLineReprojection<S>{seen.pixels.measured}.linearize(view, line.line), seen.pixels.L, loss);
  if (!seen.has_depth()) return;
  const auto depth = seen.depth.get();
  visit(AnchoredLineInverseDepth<S>{depth.measured}.linearize(view, line.line), depth.L, loss);
}

/// Gives visit(linearization, L, kernel) of what the latest frame measured, the landmark being exact.
template <class Sensors, class S>
void for_each_world_residual(PointKind<Sensors>, const Sensors& rig, const typename PointKind<Sensors>::Geometry& point,
                             const typename PointKind<Sensors>::Observation& seen, const SE3<S>& T_world_anchor,
                             const BodyView<S>& body, auto&& visit) {
  const Vec<S, 3> p_world = T_world_anchor * Vec<S, 3>(point.bearing / point.inverse_range);
  visit(PointReprojection<typename Sensors::Camera>{seen.uv.template cast<S>()}.linearize(rig.vision.camera, body,
                                                                                          p_world),
        Mat<S, 2, 2>(seen.L.template cast<S>()), Huber<S>{S(2.45)});
  const InverseDepth<S> depth = seen.depth.get();
  if (!depth.valid) return;
  visit(PointInverseDepth<S>{depth.value}.linearize(body, p_world), Mat<S, 1, 1>(1 / depth.sigma), Huber<S>{S(1.345)});
}
template <class Sensors, class S>
void for_each_world_residual(LineKind<Sensors>, const Sensors&, const LineGeometry<S>& line,
                             const typename LineKind<Sensors>::Observation& seen, const SE3<S>& T_world_anchor,
                             const BodyView<S>& body, auto&& visit) {
  const Plucker<S> in_world = T_world_anchor * line.line.plucker();
  const Huber<S> loss{S(2.45)};
  visit(WorldLine<LineReprojection<S>>{seen.pixels.measured}.linearize(body, in_world), seen.pixels.L, loss);
  if (!seen.has_depth()) return;
  const auto depth = seen.depth.get();
  visit(WorldLine<LineInverseDepth<S>>{depth.measured}.linearize(body, in_world), depth.L, loss);
}

}  // namespace plumbline::test
