#pragma once
/// Data of a bundle adjustment: keyframes on a gentle curve, points and lines before them, measurements with noise, and
/// a start with errors. Truth and measurements are double; `fill` gives them to a solver in its scalar.

#include <cmath>
#include <cstddef>
#include <vector>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/testing/gaussian.hpp"

namespace plumbline::testing {

struct SimulatedBundleOptions {
  int keyframes = 8, fixed = 2, points = 120;
  int lines = 0, points_on_line = 4;  ///< points on lines are the first ones of `points`
  double sigma_rad = 1e-3;            ///< of bearings and ends of segments
  double noise = 1;                   ///< factor of all noise; 0: measurements are exact
  double outlier_share = 0;           ///< of the bearings
  double range_share = 0;             ///< of the bearings
  bool edges = false;                 ///< odometry between neighbors
  double start_angle = 0.01, start_position = 0.05, start_point = 0.1;  ///< sigmas [rad, m, m]
  double half_view = 0.6;                                               ///< tangent
  std::uint64_t seed = 1;
};

struct SimulatedBundle {
  struct Keyframe {
    SE3<double> truth, start;
    bool is_fixed;
  };
  struct Point {
    Vec<double, 3> truth, start;
  };
  struct Observation {
    int keyframe, point;
    Vec<double, 3> bearing;
    double range, sigma_range;
    bool is_outlier;
  };
  struct Edge {
    int a, b;
    SE3<double> T_a_b;
  };
  /// Through a point with a unit direction.
  struct Line {
    Vec<double, 3> truth_point, truth_direction, start_point, start_direction;
  };
  /// An observed point of the line.
  struct Member {
    int line, point;
  };
  struct Segment {
    int keyframe, line;
    Vec<double, 3> bearing_a, bearing_b;
  };

  SimulatedBundleOptions options;
  std::vector<Keyframe> keyframes;
  std::vector<Point> points;
  std::vector<Observation> observations;
  std::vector<Edge> edges;
  std::vector<Line> lines;
  std::vector<Member> members;
  std::vector<Segment> segments;
  Gaussian noise;
  static constexpr double sigma_member = 0.003, sigma_edge_angle = 0.002, sigma_edge_position = 0.01;

  explicit SimulatedBundle(const SimulatedBundleOptions& o = {}) : options(o), noise(o.seed) {
    for (int k = 0; k < o.keyframes; ++k) {
      const SO3<double> R = SO3<double>::exp(Vec<double, 3>(0.02 * std::sin(k), -0.02 * k, 0.03 * std::cos(k)));
      const SE3<double> truth(R, Vec<double, 3>(0.25 * k, 0.1 * std::sin(0.7 * k), 0.1 * std::cos(k)));
      Vec<double, 6> error;
      error << o.start_angle * noise.vector<3>(), o.start_position * noise.vector<3>();
      const bool is_fixed = k < o.fixed;
      keyframes.push_back({truth, is_fixed ? truth : plus(truth, error), is_fixed});
    }
    const double length = 0.25 * o.keyframes;
    const auto somewhere = [&] {
      const double z = 2 + 5 * noise.random().uniform();
      const double x = -0.5 * z + (length + z) * noise.random().uniform();
      const double y = z * (noise.random().uniform() - 0.5);  // after x with every compiler
      return Vec<double, 3>(x, y, z);
    };
    for (int l = 0; l < o.lines; ++l) add_line(somewhere());
    while (int(points.size()) < o.points) add_point(somewhere());
    for (int k = 0; k + 1 < o.keyframes && o.edges; ++k) {
      Vec<double, 6> error;
      error << sigma_edge_angle * noise.vector<3>(), sigma_edge_position * noise.vector<3>();
      edges.push_back({k, k + 1, plus(keyframes[k].truth.inverse() * keyframes[k + 1].truth, o.noise * error)});
    }
  }

  Mat<double, 6, 6> edge_covariance() const {
    Vec<double, 6> sigma;
    sigma << Vec<double, 3>::Constant(sigma_edge_angle), Vec<double, 3>::Constant(sigma_edge_position);
    return sigma.cwiseProduct(sigma).asDiagonal();
  }

  /// Indices in the solver are those of the vectors. False where it refused something.
  template <class S, class Solver>
  bool fill(Solver& solver) const {
    bool ok = true;
    const S sigma = S(options.sigma_rad);
    for (const Keyframe& k : keyframes) ok &= solver.add_keyframe(k.start.template cast<S>(), k.is_fixed) >= 0;
    for (const Point& p : points) ok &= solver.add_point(cast_to<S>(p.start)) >= 0;
    for (const Observation& o : observations) {
      ok &=
          solver.add_observation(o.keyframe, o.point, cast_to<S>(o.bearing), sigma, S(o.range), S(o.sigma_range)) >= 0;
    }
    for (const Line& l : lines) ok &= solver.add_line(cast_to<S>(l.start_point), cast_to<S>(l.start_direction)) >= 0;
    for (const Segment& s : segments) {
      ok &=
          solver.add_line_observation(s.keyframe, s.line, cast_to<S>(s.bearing_a), cast_to<S>(s.bearing_b), sigma) >= 0;
    }
    for (const Member& m : members) ok &= solver.add_to_line(m.line, m.point, S(sigma_member));
    for (const Edge& e : edges) {
      ok &= solver.add_edge(e.a, e.b, e.T_a_b.template cast<S>(), cast_to<S>(edge_covariance()));
    }
    return ok;
  }

 private:
  bool is_visible(const Vec<double, 3>& p_cam) const {
    return p_cam.z() > 0.5 && std::abs(p_cam.x()) < options.half_view * p_cam.z() &&
           std::abs(p_cam.y()) < options.half_view * p_cam.z();
  }
  Vec<double, 3> measured_bearing(const Vec<double, 3>& p_cam, double sigma) {
    const Vec<double, 3> b = p_cam.normalized(), x = unit_orthogonal(b);
    const double along_x = noise(), along_y = noise();
    return (b + sigma * (along_x * x + along_y * b.cross(x))).normalized();
  }
  void add_point(const Vec<double, 3>& truth) {
    points.push_back({truth, truth + options.start_point * noise.vector<3>()});
    for (int k = 0; k < options.keyframes; ++k) {
      const Vec<double, 3> p_cam = keyframes[std::size_t(k)].truth.inverse() * truth;
      if (!is_visible(p_cam)) continue;
      const bool is_outlier = noise.random().uniform() < options.outlier_share;
      const double sigma = options.noise * options.sigma_rad + (is_outlier ? 0.1 : 0);
      Observation o{k, int(points.size()) - 1, measured_bearing(p_cam, sigma), 0, 0, is_outlier};
      if (noise.random().uniform() < options.range_share) {
        o.sigma_range = 0.005 * p_cam.squaredNorm();
        o.range = 1 / (1 / p_cam.norm() + options.noise * 0.005 * noise());
      }
      observations.push_back(o);
    }
  }
  /// A line, its points and their segments.
  void add_line(const Vec<double, 3>& middle) {
    const Vec<double, 3> direction = noise.vector<3>().normalized();
    Line line{middle, direction, middle + options.start_point * noise.vector<3>(), {}};
    line.start_direction = (direction + options.start_point * noise.vector<3>()).normalized();
    const int index = int(lines.size()), n = options.points_on_line;
    lines.push_back(line);
    for (int m = 0; m < n; ++m) {
      const int point = int(points.size());
      add_point(middle + (1.2 * m / (n - 1) - 0.6) * direction);
      if (!observations.empty() && observations.back().point == point) members.push_back({index, point});
    }
    for (int k = 0; k < options.keyframes; ++k) {
      const SE3<double> T = keyframes[std::size_t(k)].truth.inverse();
      const Vec<double, 3> a = T * Vec<double, 3>(middle - 0.6 * direction);
      const Vec<double, 3> b = T * Vec<double, 3>(middle + 0.6 * direction);
      if (!is_visible(a) || !is_visible(b)) continue;
      const double sigma = options.noise * options.sigma_rad;
      segments.push_back({k, index, measured_bearing(a, sigma), measured_bearing(b, sigma)});
    }
  }
};

}  // namespace plumbline::testing
