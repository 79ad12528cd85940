// Terms of points in one frame: information and gradient against numeric derivatives and a plain inverse of the
// covariance (docs/math/point.md (10)), and the gate.

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <memory>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/feature/landmark_store.hpp"
#include "plumbline/feature/motion_terms.hpp"
#include "plumbline/feature/point_kind.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/state/frame_window.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"
#include "plumbline/testing/simulated_points.hpp"

using namespace plumbline;

namespace {

template <class S>
struct Scene {
  using Sensors = Rig<Rgbd<Pinhole<S>, 64 * 64>>;
  using Store = LandmarkStore<PointKind<Sensors>, 64, 3>;
  using Terms = MotionTerms<Store>;

  testing::SimulatedPoints points;
  Sensors rig{};
  SE3<double> T_body_cam{SO3<double>::exp({0.1, -0.2, 0.3}), Vec<double, 3>(0.05, -0.1, 0.02)};
  SE3<double> T_keyframe{SO3<double>(), Vec<double, 3>(0, 0, -3)};
  SE3<double> T_frame{SO3<double>::exp({0.05, -0.1, 0.2}), Vec<double, 3>(0.3, 0.1, -2.9)};
  Store store{{}};
  FrameWindow<S, VisualLayout, 3> window;
  std::unique_ptr<Terms> terms = std::make_unique<Terms>();

  /// Landmarks of one keyframe, observed once more by the latest frame.
  explicit Scene(int count, double noise_scale = 1) {
    rig.vision.camera = {S(460), S(460), S(319.5), S(239.5), {}};
    points.noise_scale = noise_scale;
    points.scatter(count, {0.8, 0.6, 0.8}, 5);
    testing::Gaussian noise(7);
    window.insert(0, {T_keyframe.template cast<S>()});
    points.observe(store, T_keyframe * T_body_cam, 0, noise);
    window.insert(1, {T_frame.template cast<S>()});
    points.observe(store, T_frame * T_body_cam, 1, noise);
  }
  void collect() { terms->collect(store, window, T_body_cam.template cast<S>()); }
  BodyView<S> body(const SE3<double>& T_world_body) const {
    return {T_world_body.template cast<S>(), T_body_cam.template cast<S>()};
  }
  /// By the errors at a pose.
  int gate(const SE3<double>& T_world_body) {
    DenseNormalEquations<S, 6> system;
    terms->accumulate(rig, body(T_world_body), system);
    return terms->gate(store, S(13.8));
  }
};

/// Pixel and inverse depth of a landmark in the latest frame less what was measured, at another pose or inverse range.
template <class S>
Vec<double, 3> error(const Scene<S>& scene, std::size_t i, const SE3<double>& T_world_body, double lambda) {
  const auto& landmark = scene.store.landmarks()[i];
  const Vec<double, 3> bearing = landmark.geometry.bearing.template cast<double>();
  const SE3<double> T_cam_anchor = (T_world_body * scene.T_body_cam).inverse() * scene.T_keyframe * scene.T_body_cam;
  const Vec<double, 3> p_cam = T_cam_anchor * Vec<double, 3>(bearing / lambda);
  const Vec<double, 2> uv = landmark.current.uv.template cast<double>();
  Vec<double, 3> out;
  out << scene.points.camera.project(p_cam).uv - uv, 1 / p_cam.z() - double(landmark.current.depth.get().value);
  return out;
}

template <class S>
constexpr double tolerance = std::is_same_v<S, float> ? 1e-3 : 1e-6;

}  // namespace

TEMPLATE_TEST_CASE("motion_terms (points): rows of the pose, whitened by pixel and landmark together", "", float,
                   double) {
  using S = TestType;
  Scene<S> scene(1, 0.2);  // one landmark: the system is its rows
  REQUIRE(scene.store.landmarks().size() == 1);
  auto& landmark = scene.store.landmarks()[0];
  landmark.current.L << 2.0f, 0.7f, 0.0f, 0.5f;
  const bool has_depth = GENERATE(true, false);
  const InverseDepth<S> depth = landmark.current.depth.get();
  landmark.current.depth.set({has_depth, depth.value, depth.sigma});
  const double sigma_lambda = GENERATE(0.0, 0.003, 0.1);
  landmark.geometry.sigma_inverse_range = S(sigma_lambda);
  scene.collect();
  REQUIRE(scene.terms->size() == 1);
  DenseNormalEquations<S, 6> system;
  scene.terms->accumulate(scene.rig, scene.body(scene.T_frame), system);

  const double lambda = double(landmark.geometry.inverse_range), sigma_z = double(depth.sigma);
  const Mat<double, 3, 6> J =
      testing::numeric_jacobian<3, 6>([&](const SE3<double>& T) { return error(scene, 0, T, lambda); }, scene.T_frame);
  const Vec<double, 3> J_lambda = testing::numeric_jacobian<3, 1>(
      [&](const Vec<double, 1>& x) { return error(scene, 0, scene.T_frame, x[0]); }, Vec<double, 1>(lambda));
  const Vec<double, 3> r = error(scene, 0, scene.T_frame, lambda);

  const Mat<double, 2, 2> L = landmark.current.L.template cast<double>();
  const Vec<double, 2> j = J_lambda.head<2>() * sigma_lambda;
  Mat<double, 3, 3> information = Mat<double, 3, 3>::Zero();
  information.topLeftCorner<2, 2>() = ((L.transpose() * L).inverse() + j * j.transpose()).inverse();  // (10)
  if (has_depth) {
    information(2, 2) = 1 / (sigma_z * sigma_z + J_lambda[2] * J_lambda[2] * sigma_lambda * sigma_lambda);
  }
  CAPTURE(has_depth, sigma_lambda);
  REQUIRE(r.dot(information * r) < 1.8);  // within the kernels, weight one
  const Mat<double, 6, 6> H = J.transpose() * information * J;
  const Vec<double, 6> b = J.transpose() * information * r;
  REQUIRE((system.H().template cast<double>() - H).norm() < tolerance<S> * H.norm());
  REQUIRE((system.b().template cast<double>() - b).norm() < tolerance<S> * (b.norm() + 0.1 * std::sqrt(H.norm())));
  REQUIRE(double(system.cost()) == Approx(r.dot(information * r) / 2).epsilon(20 * tolerance<S>));
}

TEMPLATE_TEST_CASE("motion_terms (points): only located landmarks that the frame sees", "", float, double) {
  Scene<TestType> scene(10);
  scene.store.landmarks()[2].located = false;
  scene.store.landmarks()[5].current.valid = false;
  scene.collect();
  REQUIRE(scene.terms->size() == scene.store.landmarks().size() - 2);
}

TEMPLATE_TEST_CASE("motion_terms (points): the gate takes out planted outliers, and NaN", "", float, double) {
  Scene<TestType> scene(50);
  const int count = int(scene.store.landmarks().size());
  REQUIRE(count > 40);
  for (int i = 0; i < count; ++i) {
    auto& seen = scene.store.landmarks()[std::size_t(i)].current;
    if (i % 5 == 1) seen.uv += Vec<float, 2>(0, i % 2 == 0 ? 15 : -15);
    if (i % 10 == 2) seen.uv.x() = std::numeric_limits<float>::quiet_NaN();
  }
  scene.collect();
  const int kept = scene.gate(scene.T_frame);
  int valid = 0;
  for (int i = 0; i < count; ++i) {
    CAPTURE(i);
    const bool planted = i % 5 == 1 || i % 10 == 2, stays = scene.store.landmarks()[std::size_t(i)].current.valid;
    REQUIRE((!planted || !stays));
    valid += stays;
  }
  REQUIRE(kept == valid);
  REQUIRE(kept >= count * 2 / 3);
}

TEMPLATE_TEST_CASE("motion_terms (points): a frame in which all errors are large weighs less, and keeps its points", "",
                   float, double) {
  const auto weight_after_gate = [](double noise_scale, int& kept) {
    Scene<TestType> scene(60, noise_scale);
    const float before = scene.store.landmarks()[0].current.L(0, 0);
    scene.collect();
    kept = scene.gate(scene.T_frame);
    float after = 0;
    for (const auto& landmark : scene.store.landmarks()) after = std::max(after, landmark.current.L(0, 0));
    return after / before;
  };
  int kept = 0;
  REQUIRE(weight_after_gate(0.5, kept) == 1);
  REQUIRE(kept > 45);
  REQUIRE(weight_after_gate(10, kept) < 0.4f);
  REQUIRE(kept > 45);
}

TEMPLATE_TEST_CASE("motion_terms (points): a pose that is no number keeps nothing", "", float, double) {
  using S = TestType;
  Scene<S> scene(20);
  scene.collect();
  const SE3<double> T(SO3<double>(), Vec<double, 3>::Constant(std::numeric_limits<double>::quiet_NaN()));
  DenseNormalEquations<S, 6> system;
  scene.terms->accumulate(scene.rig, scene.body(T), system);
  Vec<S, 6> d;
  REQUIRE_FALSE(system.solve(d));
  REQUIRE(scene.gate(T) == 0);
  for (const auto& landmark : scene.store.landmarks()) REQUIRE_FALSE(landmark.current.valid);
}

TEST_CASE("motion_terms (points): a frame without points") {
  Scene<double> scene(0);
  scene.collect();
  REQUIRE(scene.gate(scene.T_frame) == 0);
}
