#pragma once
/// Features without images: random points and segments near the walls of a room, and what a camera measures of them.
/// For tests of solvers and estimators. Noise of frame `i` depends on the seed and i alone.

#include <cstdint>
#include <vector>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/testing/gaussian.hpp"

namespace plumbline::testing {

struct SimulatedWorldOptions {
  int points = 2000, segments = 400;
  Vec<double, 3> half_extent{3.2, 2.7, 1.35};  ///< [m] of the room; its floor is z = 0 as in testing/scenes.hpp
  double shell = 0.7;                          ///< [m] depth of the layer of features in front of the walls
  double pixel_sigma = 1.0;                    ///< [px] per coordinate
  double inverse_depth_sigma = 1.5e-3;         ///< [1/m]: constant, as sigma_z = k z^2 is sigma_(1/z) = k
  double z_min = 0.3;                          ///< [m] nearest feature measured
  std::uint64_t seed = 1;
};

/// A measurement of a point; `exact` is the same without noise.
struct PointView {
  struct Values {
    Vec<double, 2> uv;     ///< [px]
    double inverse_depth;  ///< 1/z [1/m]
  };
  int id;
  Values measured, exact;
};

/// A measurement of a segment whose ends are both in the image.
struct SegmentView {
  int id;
  PointView::Values measured_start, measured_end, exact_start, exact_end;
};

struct Segment {
  Vec<double, 3> start, end;  ///< world [m]
};

template <CameraModel Camera>
class SimulatedWorld {
 public:
  SimulatedWorld(const Camera& camera, int width, int height, const SimulatedWorldOptions& options = {})
      : camera_(camera), width_(width), height_(height), options_(options) {
    Random random(stream_seed(options.seed, 5));
    for (int i = 0; i < options.points; ++i) points_.push_back(random_point(random));
    while (segments_.size() < static_cast<std::size_t>(options.segments)) {  // edges along the axes of the room
      const Vec<double, 3> start = random_point(random);
      const int axis = static_cast<int>(random.below(3));
      Vec<double, 3> end = start;
      end[axis] += (random.uniform() < 0.5 ? -1 : 1) * (0.3 + random.uniform());
      if (in_room(end)) segments_.push_back({start, end});
    }
  }

  const std::vector<Vec<double, 3>>& points() const { return points_; }  ///< world [m]; a view's id is the index
  const std::vector<Segment>& segments() const { return segments_; }

  /// The points seen in frame `i` from that pose.
  std::vector<PointView> observe_points(const SE3<double>& T_world_cam, std::uint64_t i) const {
    Gaussian noise(stream_seed(options_.seed, 6, i));
    std::vector<PointView> out;
    const SE3<double> T_cam_world = T_world_cam.inverse();
    for (std::size_t id = 0; id < points_.size(); ++id) {
      PointView view{static_cast<int>(id), {}, {}};
      if (!project(T_cam_world * points_[id], view.exact)) continue;
      view.measured = disturbed(view.exact, noise);
      out.push_back(view);
    }
    return out;
  }

  /// The segments seen whole in frame `i` from that pose.
  std::vector<SegmentView> observe_segments(const SE3<double>& T_world_cam, std::uint64_t i) const {
    Gaussian noise(stream_seed(options_.seed, 7, i));
    std::vector<SegmentView> out;
    const SE3<double> T_cam_world = T_world_cam.inverse();
    for (std::size_t id = 0; id < segments_.size(); ++id) {
      SegmentView view{static_cast<int>(id), {}, {}, {}, {}};
      if (!project(T_cam_world * segments_[id].start, view.exact_start)) continue;
      if (!project(T_cam_world * segments_[id].end, view.exact_end)) continue;
      view.measured_start = disturbed(view.exact_start, noise);
      view.measured_end = disturbed(view.exact_end, noise);
      out.push_back(view);
    }
    return out;
  }

 private:
  bool in_room(const Vec<double, 3>& p) const {
    const Vec<double, 3>& h = options_.half_extent;
    return ((p - Vec<double, 3>(0, 0, h.z())).cwiseAbs().array() <= h.array()).all();
  }

  /// At a wall (floor and ceiling: one in five), up to `shell` into the room.
  Vec<double, 3> random_point(Random& random) const {
    Vec<double, 3> p;
    for (int k = 0; k < 3; ++k) p[k] = (2 * random.uniform() - 1) * options_.half_extent[k];
    const int axis = static_cast<int>(random.below(5)) / 2;
    p[axis] = (random.uniform() < 0.5 ? -1 : 1) * (options_.half_extent[axis] - options_.shell * random.uniform());
    p.z() += options_.half_extent.z();
    return p;
  }

  bool project(const Vec<double, 3>& p_cam, PointView::Values& out) const {
    using S = typename Camera::Scalar;
    if (!(p_cam.z() > options_.z_min)) return false;
    const Projection<S> projection = camera_.project(p_cam.cast<S>());
    if (!projection.valid) return false;
    out = {projection.uv.template cast<double>(), 1 / p_cam.z()};
    return out.uv.x() >= 0 && out.uv.y() >= 0 && out.uv.x() <= width_ - 1 && out.uv.y() <= height_ - 1;
  }

  PointView::Values disturbed(const PointView::Values& exact, Gaussian& noise) const {
    const Vec<double, 2> uv = exact.uv + options_.pixel_sigma * noise.vector<2>();
    return {uv, exact.inverse_depth + options_.inverse_depth_sigma * noise()};
  }

  Camera camera_;
  int width_, height_;
  SimulatedWorldOptions options_;
  std::vector<Vec<double, 3>> points_;
  std::vector<Segment> segments_;
};

}  // namespace plumbline::testing
