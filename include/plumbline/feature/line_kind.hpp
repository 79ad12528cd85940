#pragma once
/// Feature kind: straight edges, each an infinite line in the camera of its anchor.
///                                                                        docs/math/line.md, docs/math/window.md
/// Terms in the window, over all frames, the anchor included:
///   1/2 rho(|L r_endpoints|^2) + 1/2 rho(|L_z r_inverse_depths|^2)
/// In every step the increment of a landmark has a prior with sigma 1 on each of its four angles,                  (31)
/// because views may leave some of them unobservable (all in one plane through the line, or a distant line). A landmark
/// whose distance is not determined after the step is removed.
///
/// Its rows in the window are those of line_rows.hpp, its rows of pose refinement those of line_in_world.hpp.

#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/present.hpp"
#include "plumbline/feature/feature_kind.hpp"
#include "plumbline/feature/line_geometry.hpp"
#include "plumbline/feature/line_in_world.hpp"
#include "plumbline/feature/line_rows.hpp"
#include "plumbline/feature/readout_derivatives.hpp"
#include "plumbline/feature/segment_observation.hpp"
#include "plumbline/feature/whitened_rows.hpp"
#include "plumbline/residual/anchored_line.hpp"
#include "plumbline/residual/relative_view.hpp"
#include "plumbline/residual/world_line.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/solver/robust_loss.hpp"

namespace plumbline {

template <SensorRig SensorsT, template <class> class Loss = Huber,
          class ObservationT = SegmentObservation<typename SensorsT::Scalar, SensorsT::has_depth, SensorsT::rolls>>
struct LineKind {
  using Sensors = SensorsT;
  using Scalar = typename Sensors::Scalar;
  using S = Scalar;
  using Observation = ObservationT;
  using Place = LineSegment;  ///< in the image [px]
  using Geometry = LineGeometry<S>;
  static constexpr int dim = 4;
  static constexpr int rows_per_view = Observation::measures_depth ? 4 : 2, damping_rows = dim;
  static_assert(RobustLoss<Loss<S>>, "plumbline: this is no robust kernel, see solver/robust_loss.hpp");
  static constexpr Loss<S> pixel_loss = loss_for<Loss, S, 2>, depth_loss = pixel_loss;

  struct Appearance {
    LineProfile profile;  ///< of the latest inlier observation
    float gradient = 0;   ///< gradient of the same observation [intensity/px]
  };

  // -------------------------------------------------------------------------------------------------- geometry

  /// Middle of the part observed last, in the camera of the anchor [m].
  static Vec<S, 3> middle(const Geometry& line) { return line.middle(); }
  static S inverse_range(const Geometry& line) { return S(1) / norm(line.middle()); }
  static void rescale(Geometry& line, S scale) { line.rescale(scale); }
  static void change_readout(Geometry& line, const Observation& seen_by_anchor, S change_s) {
    if (!seen_by_anchor.valid) return;
    line.change(change_s * line.derivative(seen_by_anchor.pixels.measured, seen_by_anchor.by_readout()));
  }
  /// Corrects an observation by the anchor for the range of the line, see row_ranges.hpp.
  static void set_range_in_anchor(const Geometry& line, Observation& seen, S readout_s) {
    seen.set_line(line.line.plucker(), readout_s);
  }
  /// The same for another frame.
  static void set_range(const Geometry& line, Observation& seen, const SE3<S>& T_cam_anchor, S readout_s) {
    seen.set_line(T_cam_anchor * line.line.plucker(), readout_s);
  }
  /// Corrects geometry and observation for another motion of the anchor's camera during its readout, see
  /// row_motion.hpp.
  static void set_motion_in_anchor(Geometry& line, Observation& seen, const auto& shutter, S readout_s) {
    const LineReprojection<S> before = seen.pixels.measured;
    line.change(line.derivative(before, seen.set_motion(shutter, readout_s)));
  }
  /// Mean normal displacement of both ends times pi/2: of a motion in a random direction an edge shows the normal
  /// component alone, on average 2/pi of it.
  static double motion_px(const Observation& then, const Observation& now) {
    constexpr double half_pi = 1.5707963267948966;
    const LineSegment& edge = now.segment;
    return half_pi * (std::abs(edge.distance(then.segment.start)) + std::abs(edge.distance(then.segment.end))) / 2;
  }

  static void step(Geometry& line, const Vec<S, dim>& d) { line.line = line.line.plus(d); }
  /// After convergence: sets the covariance, the poses fixed; null without one. False when the line is not determined.
  static bool set_covariance(Geometry& line, const Observation& seen_by_anchor, const Mat<S, dim, dim>* covariance) {
    if (covariance) line.covariance = *covariance;
    return covariance && line.is_sound(seen_by_anchor.pixels.measured);
  }

  // --------------------------------------------------------------------------------------------- in the window

  struct InAnchor {
    Plucker<S> plucker;
    explicit InAnchor(const Geometry& line) : plucker(line.line.plucker()) {}
  };
  struct Linearized : LinearizedLine<S> {
    explicit Linearized(const Geometry& line) : LinearizedLine<S>(line.line) {}
  };

  /// Adds the weighted rows of the observation by the anchor, or their derivatives by the readout time; returns the
  /// cost.
  template <class Rows>
  static double add_anchor(const Linearized& line, const Observation& seen, Rows& rows) {
    const Measured measured(seen, line.plucker, pixel_loss);
    if constexpr (TakesDerivatives<Rows>) {
      measured.add_derivatives(rows, seen, line.plucker);
    } else if (measured.rows > 0) {
      add_to(rows, measured, by_landmark(measured.lin, line));
    }
    return measured.cost;
  }
  /// Adds the pixel rows of the anchor, which determine the line when another frame is marginalized. The depth rows
  /// stay with the landmark: they must not count twice.
  template <class Rows>
  static void add_anchor_pixels(const Linearized& line, const Observation& seen, Rows& rows) {
    const Measured measured(seen.pixels, line.plucker, pixel_loss);
    if constexpr (TakesDerivatives<Rows>) {
      measured.add_derivatives(rows, seen, line.plucker);
    } else if (measured.rows > 0) {
      add_to(rows, measured, by_landmark(measured.lin, line));
    }
  }
  /// Adds the weighted rows of the observation by the frame in `slot`, not the anchor, or their derivatives by the
  /// readout time; returns the cost.
  template <class Rows>
  static double add_view(const Sensors&, const Linearized& line, const Observation& seen, const RelativeView<S>& view,
                         int slot, Rows& rows) {
    const Plucker<S> in_target = line_in_target(view, line.plucker);
    const Measured measured(seen, in_target, pixel_loss);
    if (measured.rows == 0) return invalid_cost;
    if constexpr (TakesDerivatives<Rows>) {
      measured.add_derivatives(rows, seen, in_target);
    } else {
      const Mat<S, rows_per_view, 6> J_pose =
          line_pose_jacobian(measured.lin, in_target, Mat<S, 3, 3>(view.R_body_cam().transpose()), view.p_body_cam());
      const Mat<S, rows_per_view, dim> J_line = by_landmark(by_line_in_anchor(measured.lin, view), line);
      add_to(rows, measured, J_line, slot, J_pose);
    }
    return measured.cost;
  }

  /// Adds the rows of (31).
  template <class Rows>
  static void add_damping(Rows& rows) {
    rows.template add<dim>(identity<S, dim>(), zeros<S, dim>());
  }

  static double cost_in_anchor(const InAnchor& line, const Observation& seen) {
    const Errors errors = errors_of(seen, line.plucker);
    return errors.valid ? cost_of(errors) : invalid_cost;
  }
  static double cost(const Sensors&, const InAnchor& line, const Observation& seen, const RelativeView<S>& view) {
    const Errors errors = errors_of(seen, line_in_target(view, line.plucker));
    return errors.valid ? cost_of(errors) : invalid_cost;
  }

  /// Rejects outlier measurements of the anchor: depth only, since its segment defines the extent of the line.
  static void reject_outliers_in_anchor(const InAnchor& line, Observation& seen) {
    reject_outlier_depth(errors_of(seen, line.plucker), seen);
  }
  static void reject_outliers(const Sensors&, const InAnchor& line, Observation& seen, const RelativeView<S>& view) {
    const Errors errors = errors_of(seen, line_in_target(view, line.plucker));
    seen.valid = errors.valid && squared_norm(errors.pixels) < drop_chi2;
    reject_outlier_depth(errors, seen);
  }

  // --------------------------------------------------------------------------------------------- in one frame

  using InWorld = LineInWorld<Observation>;
  static InWorld in_world(const Geometry& line, const Observation& current, const SE3<S>& T_world_anchor) {
    const Mat<S, 6, 6> to_world = plucker_transform(T_world_anchor);
    const Mat<S, 6, 4> M = to_world * line.line.plucker_jacobian();
    return {T_world_anchor * line.line.plucker(), M * line.covariance * M.transpose(), current};
  }
  static WhitenedRows<S, 2> pixel_rows(const Sensors&, const BodyView<S>& view, const InWorld& line) {
    return line.pixel_rows(view);
  }
  static double error_px(const Sensors&, const BodyView<S>& view, const InWorld& line) { return line.error_px(view); }
  static constexpr int depth_dim = Observation::measures_depth ? 2 : 0;
  static bool has_depth(const InWorld& line) { return line.seen.has_depth(); }
  static WhitenedRows<S, 2> depth_rows(const BodyView<S>& view, const InWorld& line) { return line.depth_rows(view); }

 private:
  using Measured = LineRows<Observation, Loss<S>>;
  static constexpr double invalid_cost = Measured::invalid_cost;
  /// Whitened squared error of an outlier; chi-square quantile 99.9996 %, 2 degrees of freedom.
  static constexpr S drop_chi2 = S(25);

  /// Whitened errors of one observation.
  struct Errors {
    bool valid;
    Vec<S, 2> pixels;
    Vec<S, 2> depth;  ///< zero without a measurement
  };

  static Errors errors_of(const Observation& seen, const Plucker<S>& line) {
    const LineReprojection<S>& pixels = seen.pixels.measured;
    Errors out{line_visible<S>(line, pixels.bearing_start + pixels.bearing_end), zeros<S, 2>(), zeros<S, 2>()};
    if (!out.valid) return out;
    out.pixels = seen.pixels.L * pixels.residual(line);
    const auto& depth = seen.depth.get();
    if (depth.valid) out.depth = depth.L * depth.measured.residual(line);
    return out;
  }
  static double cost_of(const Errors& errors) {
    return (pixel_loss.rho(squared_norm(errors.pixels)) + depth_loss.rho(squared_norm(errors.depth))) / 2;
  }
  static void reject_outlier_depth(const Errors& errors, Observation& seen) {
    if (seen.has_depth() && !(squared_norm(errors.depth) < drop_chi2)) seen.clear_depth();
  }

  /// Adds the valid rows; `pose`: `slot` and J_pose, for frames other than the anchor.
  template <class Rows, class... Pose>
  static void add_to(Rows& rows, const Measured& measured, const Mat<S, rows_per_view, dim>& J_line,
                     const Pose&... pose) {
    if constexpr (rows_per_view > 2) {
      if (measured.rows == rows_per_view) return add_top<rows_per_view>(rows, measured, J_line, pose...);
    }
    add_top<2>(rows, measured, J_line, pose...);
  }
  template <int R, class Rows>
  static void add_top(Rows& rows, const Measured& measured, const Mat<S, rows_per_view, dim>& J_line) {
    rows.template add<R>(block<R, dim>(J_line, 0, 0), segment<R>(measured.lin.r, 0));
  }
  template <int R, class Rows>
  static void add_top(Rows& rows, const Measured& measured, const Mat<S, rows_per_view, dim>& J_line, int slot,
                      const Mat<S, rows_per_view, 6>& J_pose) {
    rows.template add<R>(slot, block<R, 6>(J_pose, 0, 0), block<R, dim>(J_line, 0, 0), segment<R>(measured.lin.r, 0));
  }
};

}  // namespace plumbline
