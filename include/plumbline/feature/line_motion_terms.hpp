#pragma once
/// What the lines say about the pose of one frame, their map being given.                   docs/math/line.md
///
/// A landmark's own covariance C widens its residuals:  Sigma_r = Sigma + J_line C_w J_line^T,
/// C_w = M C M^T,  M = d(n_w; v_w)/d theta                                                                     (29)
/// The readout time of a rolling shutter moves observation and landmark (docs/math/rolling_shutter.md):
///   dr/d readout = J_line d(n_w; v_w)/d readout + dr/d bearing d bearing/d readout,   dr_i/d bearing_i = k_i nh^T
/// The depth rows neglect it: their noise is larger.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/line_landmark.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/residual/world_line.hpp"
#include "plumbline/solver/gauss_newton.hpp"
#include "plumbline/solver/robust_loss.hpp"

namespace plumbline {

template <SensorRig Sensors, class Map>
class LineMotionTerms {
 public:
  using S = typename Sensors::Scalar;
  using Landmark = typename Map::Landmark;
  using Window = typename Map::Window;

  /// All located landmarks that the latest frame sees.
  void collect(const View<Sensors>& view, const Map& map, const Window& window) {
    lines_.clear();
    for (std::size_t i = 0; i < map.landmarks().size(); ++i) {
      const Landmark& landmark = map.landmarks()[i];
      if (!landmark.current.valid || !landmark.located) continue;
      const SE3<S> T_world_cam = window[landmark.anchor].pose.value() * view.T_body_cam;
      const Mat<S, 6, 6> to_world = plucker_transform(T_world_cam);
      const Mat<S, 6, 4> M = to_world * landmark.line.plucker_jacobian();
      lines_.push_back({static_cast<int>(i), T_world_cam * landmark.line.plucker(),
                        M * landmark.covariance * M.transpose(), to_world * landmark.line_slope(), landmark.current});
    }
  }

  std::size_t size() const { return lines_.size(); }

  /// Adds the weighted rows at a pose; of pose and readout time where the system has seven parameters.
  template <int Dim>
  void accumulate(const Sensors&, const BodyView<S>& view, DenseNormalEquations<S, Dim>& system) const {
    static_assert(Dim == 6 || Dim == 7);
    for (const Line& line : lines_) {
      add_rows(pixel_rows(view, line), system);
      if (line.seen.has_depth) add_rows(depth_rows(view, line), system);
    }
  }

  /// Takes observations beyond `chi2` (two degrees of freedom) out of the frame; returns how many stay. The frame's own
  /// scale is the median of all errors: blur and rolling shutter make all of them larger, and then all weigh less.
  int gate(const Sensors&, Map& map, const BodyView<S>& view, S chi2) {
    errors_.clear();
    for (const Line& line : lines_) {
      const Rows rows = pixel_rows(view, line);
      errors_.push_back(rows.valid ? rows.r.squaredNorm() : std::numeric_limits<S>::infinity());
    }
    sorted_ = errors_;
    const std::size_t middle = sorted_.size() / 2;
    std::nth_element(sorted_.begin(), sorted_.begin() + middle, sorted_.end());
    const S scale2 = sorted_.empty() ? S(1) : std::max(S(1), sorted_[middle] / S(1.386));  // median of chi2(2)
    int inliers = 0;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      if (errors_[i] < chi2 * scale2) {
        ++inliers;
        map.scale_sigma(lines_[i].index, std::sqrt(scale2));
      } else {
        map.reject_current(lines_[i].index);
      }
    }
    return inliers;
  }

 private:
  struct Line {
    int index;
    Plucker<S> world;
    Mat<S, 6, 6> world_covariance;  ///< C_w of (29)
    Vec<S, 6> world_slope;          ///< d(n_w; v_w)/d readout [1/s]
    SegmentObservation<S> seen;
  };
  /// Whitened.
  struct Rows {
    bool valid = false;
    Vec<S, 2> r;
    Mat<S, 2, 7> J;  ///< pose, readout
  };

  template <int Dim>
  void add_rows(const Rows& rows, DenseNormalEquations<S, Dim>& system) const {
    if (!rows.valid) return;
    const S s = rows.r.squaredNorm();
    system.add(Mat<S, 2, Dim>(rows.J.template leftCols<Dim>()), rows.r, loss_.weight(s));
    system.add_cost(loss_.rho(s));
  }

  Rows pixel_rows(const BodyView<S>& view, const Line& line) const {
    const LineReprojection<S>& pixels = line.seen.pixels;
    const auto lin = WorldLine<LineReprojection<S>>{pixels}.linearize(view, line.world);
    if (!lin.valid) return {};
    const Vec<S, 3> nh = line_in_camera(view, line.world).n.normalized();
    Vec<S, 2> by_readout = lin.J_r_line * line.world_slope;
    for (int i = 0; i < 2; ++i) by_readout[i] += pixels.px_per_rad[i] * nh.dot(line.seen.bearing_slope.col(i));
    return whitened(lin, by_readout, line.seen.pixels_covariance, line);
  }

  Rows depth_rows(const BodyView<S>& view, const Line& line) const {
    const auto lin = WorldLine<LineInverseDepth<S>>{line.seen.depth}.linearize(view, line.world);
    if (!lin.valid) return {};
    return whitened(lin, Vec<S, 2>::Zero(), line.seen.depth_covariance, line);
  }

  template <class Linearized>
  static Rows whitened(const Linearized& lin, const Vec<S, 2>& by_readout, const Mat<S, 2, 2>& covariance,
                       const Line& line) {
    const Mat<S, 2, 2> widened = covariance + lin.J_r_line * line.world_covariance * lin.J_r_line.transpose();  // (29)
    const Result<Mat<S, 2, 2>> W = square_root_information(widened);
    Rows out;
    out.valid = bool(W);
    if (!out.valid) return out;
    out.r.noalias() = *W * lin.r;
    out.J.template leftCols<6>().noalias() = *W * lin.J_r_pose;
    out.J.col(6).noalias() = *W * by_readout;
    return out;
  }

  Huber<S> loss_{S(2.45)};  ///< sqrt(chi2_95_2dof)
  FixedVector<Line, Map::Landmarks::capacity()> lines_;
  FixedVector<S, Map::Landmarks::capacity()> errors_, sorted_;
};

}  // namespace plumbline
