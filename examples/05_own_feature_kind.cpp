// A feature kind of one's own: planes of a camera with depth (walls, floors, cabinets). It shows what a kind consists
// of, what its landmark, its observation and its rows are, and a front end that reads the landmarks of the kind before
// it: a plane is where points lie on it, and is found again by them.
//
// A plane is pi . p = 1 in the camera of its anchor [1/m], p on it. Along the ray b = (x, y, 1) its depth z satisfies
//   pi . b = 1/z                                  linear in pi: what a depth sensor measures is fitted directly     (1)
// In a camera with p_t = R p_a + t it is
//   pi_t = q m,  m = R pi,  q = 1/(1 + m . t)                                                                      (2)
//   dpi_t/dpi     = q (I - pi_t t^T) R                                                                             (3)
//   dpi_t/d(pose) = [ R_e^T [n]x - pi_t (n x p_e)^T,  pi_t n^T ],  n = R_e pi_t,  T_body_cam = (R_e, p_e)          (4)
// and the row of an observation is L (pi_t - pi_seen), L^T L the inverse of its covariance.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <tuple>

#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/square_root_information.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/feature/whitened_rows.hpp"
#include "plumbline/residual/relative_view.hpp"
#include "plumbline/residual/world_point.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/solver/gauss_newton.hpp"
#include "plumbline/solver/robust_loss.hpp"
#include "plumbline/testing/room_run.hpp"

namespace pl = plumbline;

// ------------------------------------------------------------------------------------------------------------ the kind

/// A plane in the coordinates of another camera.
template <class S>
struct PlaneInCamera {
  bool valid;
  pl::Vec<S, 3> pi;         ///< (2)
  pl::Mat<S, 3, 3> J_pi;    ///< (3)
  pl::Mat<S, 3, 6> J_pose;  ///< (4), of the camera's body

  PlaneInCamera(const pl::Mat<S, 3, 3>& R, const pl::Vec<S, 3>& t, const pl::Vec<S, 3>& pi_anchor,
                const pl::Mat<S, 3, 3>& R_e, const pl::Vec<S, 3>& p_e) {
    const pl::Vec<S, 3> m = R * pi_anchor;
    const S q = S(1) / (S(1) + m.dot(t));
    valid = q > S(0.01) && q < S(100);  // on the same side of the plane, and not in it; false for NaN
    pi = q * m;
    J_pi = q * (pl::Mat<S, 3, 3>::Identity() - pi * t.transpose()) * R;
    const pl::Vec<S, 3> n = R_e * pi, lever = n.cross(p_e);
    J_pose << R_e.transpose() * pl::hat(n) - pi * lever.transpose(), pi * n.transpose();
  }
};

template <pl::SensorRig SensorsT>
struct PlaneKind {
  using Sensors = SensorsT;
  using Scalar = typename Sensors::Scalar;
  using S = Scalar;
  static constexpr int dim = 3, rows_per_view = 3, damping_rows = 0;
  static constexpr pl::Huber<S> pixel_loss = pl::loss_for<pl::Huber, S, 3>;

  struct Geometry {
    pl::Vec<S, 3> pi = pl::Vec<S, 3>::UnitZ();
    pl::Mat<S, 3, 3> covariance = pl::Mat<S, 3, 3>::Zero();  ///< given the poses
  };
  using Place = pl::Vec<float, 2>;
  struct Observation {
    bool valid = false;
    pl::Vec<S, 3> pi;
    pl::Mat<S, 3, 3> covariance, L;
    Place pixel;  ///< in the middle of the points that lie on it

    const Place& place() const { return pixel; }
    void scale_sigma(S scale) {
      covariance *= scale * scale;
      L /= scale;
    }
    void change_readout(S) {}
    void set_motion(const auto&, S) {}
    void rescale(S) {}
  };
  struct Appearance {
    pl::FixedVector<std::uint32_t, 100> points;  ///< ids of those that lie on it
  };

  static pl::Vec<S, 3> middle(const Geometry& plane) { return plane.pi / plane.pi.squaredNorm(); }
  static S inverse_range(const Geometry& plane) { return plane.pi.norm(); }
  static double motion_px(const Observation& then, const Observation& now) { return (now.pixel - then.pixel).norm(); }
  static void rescale(Geometry& plane, S scale) {
    plane.pi /= scale;
    plane.covariance /= scale * scale;
  }
  static void change_readout(Geometry&, const Observation&, S) {}
  static void set_range_in_anchor(Geometry&, Observation&, S) {}  // the shutter rolls too fast to mind
  static void set_range(const Geometry&, Observation&, const pl::SE3<S>&, S) {}
  static void set_motion_in_anchor(Geometry&, Observation&, const auto&, S) {}
  static void step(Geometry& plane, const pl::Vec<S, dim>& d) { plane.pi += d; }
  static bool set_covariance(Geometry& plane, const Observation&, const pl::Mat<S, dim, dim>* covariance) {
    if (covariance) plane.covariance = *covariance;
    return covariance && plane.pi.squaredNorm() < S(100);  // farther than ten centimeters; false for NaN
  }

  // In the window. Nothing is shared between the rows of one landmark.

  using InAnchor = Geometry;
  using Linearized = Geometry;

  template <class Rows>
  static double add_anchor(const Geometry& plane, const Observation& seen, Rows& rows) {
    const pl::Vec<S, 3> r = seen.L * (plane.pi - seen.pi);
    const S w = std::sqrt(pixel_loss.weight(r.squaredNorm()));
    rows.template add<3>(pl::Mat<S, 3, dim>(w * seen.L), pl::Vec<S, 3>(w * r));
    return double(pixel_loss.rho(r.squaredNorm())) / 2;
  }
  template <class Rows>
  static void add_anchor_pixels(const Geometry&, const Observation&, Rows&) {}
  template <class Rows>
  static double add_view(const Sensors&, const Geometry& plane, const Observation& seen,
                         const pl::RelativeView<S>& view, int slot, Rows& rows) {
    const PlaneInCamera<S> lin = in_camera(plane, view);
    if (!lin.valid) return invalid_cost;
    const pl::Vec<S, 3> r = seen.L * (lin.pi - seen.pi);
    const S w = std::sqrt(pixel_loss.weight(r.squaredNorm()));
    const pl::Mat<S, 3, 3> wL = w * seen.L;
    rows.template add<3>(slot, pl::Mat<S, 3, 6>(wL * lin.J_pose), pl::Mat<S, 3, dim>(wL * lin.J_pi),
                         pl::Vec<S, 3>(w * r));
    return double(pixel_loss.rho(r.squaredNorm())) / 2;
  }
  template <class Rows>
  static void add_damping(Rows&) {}

  static double cost_in_anchor(const Geometry& plane, const Observation& seen) {
    return double(pixel_loss.rho((seen.L * (plane.pi - seen.pi)).squaredNorm())) / 2;
  }
  static double cost(const Sensors&, const Geometry& plane, const Observation& seen, const pl::RelativeView<S>& view) {
    const PlaneInCamera<S> at = in_camera(plane, view);
    return at.valid ? double(pixel_loss.rho((seen.L * (at.pi - seen.pi)).squaredNorm())) / 2 : invalid_cost;
  }
  static void reject_outliers_in_anchor(const Geometry&, Observation&) {}
  static void reject_outliers(const Sensors&, const Geometry& plane, Observation& seen,
                              const pl::RelativeView<S>& view) {
    const PlaneInCamera<S> at = in_camera(plane, view);
    seen.valid = at.valid && (seen.L * (at.pi - seen.pi)).squaredNorm() < S(25);
  }

  // In one frame.

  struct InWorld {
    Geometry plane;
    pl::SE3<S> T_world_anchor;  ///< of its camera
    Observation seen;
  };
  static InWorld in_world(const Geometry& plane, const Observation& current, const pl::SE3<S>& T_world_anchor) {
    return {plane, T_world_anchor, current};
  }
  static pl::WhitenedRows<S, 3> pixel_rows(const Sensors&, const pl::BodyView<S>& view, const InWorld& plane) {
    const pl::Mat<S, 3, 3> R = view.R_cam_body * view.R_body_world * plane.T_world_anchor.R();
    const PlaneInCamera<S> lin(R, view.cam_point(plane.T_world_anchor.p()), plane.plane.pi, view.R_cam_body.transpose(),
                               view.p_body_cam);
    if (!lin.valid) return {};
    const pl::Mat<S, 3, 3> widened = plane.seen.covariance + lin.J_pi * plane.plane.covariance * lin.J_pi.transpose();
    const auto W = pl::square_root_information(widened);
    if (!W) return {};
    return pl::WhitenedRows<S, 3>::of(*W, pl::Vec<S, 3>(lin.pi - plane.seen.pi), lin.J_pose);
  }
  static constexpr int depth_dim = 0;  // no rows beside these

 private:
  static constexpr double invalid_cost = 100;
  static PlaneInCamera<S> in_camera(const Geometry& plane, const pl::RelativeView<S>& view) {
    return {view.R_target_anchor(), view.t_target_anchor(), plane.pi, view.R_body_cam(), view.p_body_cam()};
  }
};

// ------------------------------------------------------------------------------------------------------- its front end

struct PlaneOptions {
  int target_count = 8;
  std::size_t min_points = 6;   ///< that lie on a plane
  float seed_px = 24;           ///< half the side of the window in which a new plane is looked for
  double gate = 3;              ///< samples of a plane are within this many sigma,
  double min_inliers = 0.7;     ///< this part of them at least
  double samples_for_one = 10;  ///< the errors of so many samples are one
};

template <class Store>
class PlanesOfPoints {
 public:
  using Kind = typename Store::Kind;
  using Sensors = typename Kind::Sensors;
  using S = typename Kind::Scalar;
  using View = pl::View<Sensors>;
  using Landmark = typename Store::Landmark;
  using Observation = typename Kind::Observation;
  using Options = PlaneOptions;                         // reached as `options.planes`
  static constexpr bool gives_correspondences = false;  // a plane alone does not constrain a pose enough for RANSAC
  static constexpr bool reads_kinds_before = true;      // their stores are the last argument: here, that of the points

  explicit PlanesOfPoints(const Options& options) : options_(options) {}

  void follow(const View& view, const auto& /*window*/, Store& store, const pl::SE3<S>&, const auto& before) {
    for (Landmark& plane : store.landmarks()) {
      observe(view, std::get<0>(before), plane.appearance, plane.current);
      plane.misses = plane.current.valid ? 0 : plane.misses + 1;
    }
  }
  void refine(const View&, const auto&, Store&, const pl::SE3<S>&, const auto&) {}  // follow has done it
  void locate(const View&, const auto&, Store&, const pl::SE3<S>&, const auto&) {}  // depth has done it

  /// New planes around points that lie on none in sight; all take up the points that lie on them now.
  void detect(const View& view, const auto& /*window*/, Store& store, int slot, const auto& before) {
    const auto& points = std::get<0>(before).landmarks();
    for (Landmark& plane : store.landmarks()) {
      if (plane.current.valid) gather(view, points, plane.current.pi, plane.appearance);
    }
    for (const auto& seed : points) {
      if (store.seen_count() >= options_.target_count) break;
      if (!seed.current.valid || is_taken(store, seed.id)) continue;
      Landmark plane;
      const pl::Vec<float, 2> reach(options_.seed_px, options_.seed_px), at = seed.current.pixel;
      if (!fit(view, at - reach, at + reach, plane.current) || is_known(store, plane.current)) continue;
      gather(view, points, plane.current.pi, plane.appearance);
      if (plane.appearance.points.size() < options_.min_points) continue;
      observe(view, std::get<0>(before), plane.appearance, plane.current);  // by all of it
      if (!plane.current.valid) continue;
      plane.located = true;
      plane.geometry = {plane.current.pi, plane.current.covariance};
      if (!store.add(plane, slot)) break;
    }
  }

 private:
  static bool is_taken(const Store& store, std::uint32_t id) {
    return std::any_of(store.landmarks().begin(), store.landmarks().end(), [&](const Landmark& plane) {
      const auto& points = plane.appearance.points;
      return plane.current.valid && std::find(points.begin(), points.end(), id) != points.end();
    });
  }

  static bool is_known(const Store& store, const Observation& seen) {
    return std::any_of(store.landmarks().begin(), store.landmarks().end(), [&](const Landmark& plane) {
      return plane.current.valid && (seen.L * (plane.current.pi - seen.pi)).squaredNorm() < S(25);
    });
  }

  /// The points in sight whose depth is that of the plane.
  void gather(const View& view, const auto& points, const pl::Vec<S, 3>& pi, typename Kind::Appearance& out) const {
    out.points.clear();
    for (const auto& point : points) {
      pl::Vec<S, 3> b;
      const auto& depth = point.current.depth.get();
      if (!point.current.valid || !depth.valid || !ray(view, point.current.pixel, b)) continue;
      if (std::abs(pi.dot(b) - depth.value) < options_.gate * depth.sigma) out.points.push_back(point.id);
    }
  }

  /// The plane in the depth image, in the box around those of its points that the frame sees.
  void observe(const View& view, const auto& points, const typename Kind::Appearance& plane, Observation& out) const {
    out.valid = false;
    pl::Vec<float, 2> first = pl::Vec<float, 2>::Constant(1e9f), last = -first, sum = pl::Vec<float, 2>::Zero();
    std::size_t n = 0;
    for (const auto& point : points.landmarks()) {
      const auto& ids = plane.points;
      if (!point.current.valid || std::find(ids.begin(), ids.end(), point.id) == ids.end()) continue;
      first = first.cwiseMin(point.current.pixel);
      last = last.cwiseMax(point.current.pixel);
      sum += point.current.pixel;
      ++n;
    }
    if (n < options_.min_points) return;
    fit(view, first, last, out);
    out.pixel = sum / float(n);
  }

  static bool ray(const View& view, const pl::Vec<float, 2>& pixel, pl::Vec<S, 3>& b) {
    const pl::Unprojection<S> unprojected = view.camera().unproject(pixel.template cast<S>());
    if (!unprojected.valid || !(unprojected.bearing.z() > S(0.1))) return false;
    b = unprojected.bearing / unprojected.bearing.z();
    return true;
  }

  /// (1) over a grid in a box, three times with the samples that fit.
  bool fit(const View& view, const pl::Vec<float, 2>& first, const pl::Vec<float, 2>& last, Observation& out) const {
    constexpr int side = 12;
    struct Sample {
      pl::Vec<S, 3> b;
      S inverse_depth, sigma;
    };
    pl::FixedVector<Sample, side * side> samples;
    out.valid = false;
    for (int k = 0; k < side * side; ++k) {
      const pl::Vec<float, 2> part(float(k % side) / (side - 1), float(k / side) / (side - 1));
      const pl::Vec<float, 2> pixel = first + part.cwiseProduct(last - first);
      const pl::InverseDepth<S> depth = view.rig.vision.depth.at(view.depth, pixel);
      pl::Vec<S, 3> b;
      if (depth.valid && ray(view, pixel, b)) samples.push_back({b, depth.value, depth.sigma});
    }
    if (2 * samples.size() < side * side) return false;
    for (int iteration = 0; iteration < 3; ++iteration) {
      pl::DenseNormalEquations<S, 3> equations;
      std::size_t inliers = 0;
      for (const Sample& sample : samples) {
        const S error = (iteration == 0 ? S(0) : out.pi.dot(sample.b)) - sample.inverse_depth;
        if (iteration > 0 && !(std::abs(error) < S(options_.gate) * sample.sigma)) continue;
        const pl::Mat<S, 1, 3> J = sample.b.transpose();
        const S weight = S(1) / (S(options_.samples_for_one) * sample.sigma * sample.sigma);
        equations.add(J, pl::Vec<S, 1>(-sample.inverse_depth), weight);
        ++inliers;
      }
      if (double(inliers) < options_.min_inliers * double(samples.size())) return false;
      if (!equations.solve(out.pi) || !equations.covariance(out.covariance)) return false;
    }
    const auto L = pl::square_root_information(out.covariance);
    if (L) out.L = *L;
    return out.valid = bool(L);
  }

  Options options_;
};

/// The argument of Features<...>.
template <int N>
struct Planes {
  static constexpr int capacity = N;
  template <pl::SensorRig Sensors>
  using Kind = PlaneKind<Sensors>;
  template <class Store>
  using FrontEnd = PlanesOfPoints<Store>;

  template <class Options>
  struct Named {
    Options planes;
  };
  static auto& options_of(auto& all) { return all.planes; }
};

// --------------------------------------------------------------------------------------------------------------- usage

int main() {
  constexpr int width = 320, height = 240;
  using Sensors = pl::Rig<pl::Rgbd<pl::Pinhole<double>, width * height, pl::Global>>;
  using Vo = pl::Estimator<Sensors, pl::Features<pl::Points<200>, Planes<12>>, pl::SlidingWindow<6>>;
  static_assert(pl::FeatureKind<PlaneKind<Sensors>>);

  Sensors sensors{};
  sensors.vision.camera = {268, 268, 159.5, 119.5, {}};
  sensors.vision.width = width;
  sensors.vision.height = height;
  const auto vo = std::make_unique<Vo>(sensors);

  const pl::testing::RoomRun run = pl::testing::run_in_room(*vo);
  const auto& planes = vo->landmarks().get<1>();
  std::printf("%.2f m traveled, at most %.1f cm off; %d planes in sight, %d known\n", run.path_m, 100 * run.error_m,
              planes.tracked_count(), int(planes.landmarks().size()));
  for (const auto& plane : planes.landmarks()) {
    const pl::Vec<double, 3> n = plane.geometry.pi.normalized();
    std::printf("  normal (%5.2f %5.2f %5.2f), %.2f m from its camera, seen by %d keyframes, %d points\n", n.x(), n.y(),
                n.z(), 1 / plane.geometry.pi.norm(), plane.observation_count(), int(plane.appearance.points.size()));
  }
  return run.is_within(0.03) && planes.tracked_count() > 0 ? 0 : 1;
}
