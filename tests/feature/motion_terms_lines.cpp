// Terms of lines in one frame: information and gradient against numeric derivatives and a plain inverse of the
// covariance (docs/math/line.md (29)), the readout's column, and the gate.

#include <cmath>
#include <limits>
#include <memory>

#include <Eigen/LU>

#include "catch.hpp"
#include "feature/seen_lines.hpp"
#include "plumbline/feature/motion_terms.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;
using test::SeenLines;

namespace {

template <class S>
struct Scene : SeenLines<S> {
  using Base = SeenLines<S>;
  using Landmark = typename Base::Landmark;
  using Terms = MotionTerms<typename Base::Store>;
  std::unique_ptr<Terms> terms = std::make_unique<Terms>();
  /// Some pixels off the last keyframe's.
  SE3<double> T = plus(Base::T_world_body[3], Vec<double, 6>(2e-3, -1e-3, 1e-3, 4e-3, -5e-3, 3e-3));

  explicit Scene(int count, double noise_scale = 1) : Base(count, noise_scale) {
    for (Landmark& landmark : Base::store->landmarks()) {
      Mat<double, 4, 4> A;
      A << 3, 0, 0, 0, 1, 2, 0, 0, -1, 1, 3, 0, 1, -1, 2, 4;
      landmark.geometry.covariance = (1e-7 * A * A.transpose()).cast<S>();
    }
  }
  void collect() { terms->collect(*Base::store, Base::window, Base::T_body_cam.template cast<S>()); }
  BodyView<S> body(const SE3<double>& pose) const {
    return {pose.template cast<S>(), Base::T_body_cam.template cast<S>()};
  }
};

/// Gradient, information and cost of one landmark's pixels and depth at pose T, all in double.
template <class S>
void add_reference(const Scene<S>& scene, const typename Scene<S>::Landmark& original, const SE3<double>& T,
                   Mat<double, 6, 6>& H, Vec<double, 6>& b, double& cost) {
  const SE3<double> T_world_anchor =
      scene.window.T_world_body(original.anchor).template cast<double>() * scene.T_body_cam;
  const Huber<double> loss{2.45};
  const auto errors = [&](const SE3<double>& pose, const Line3<double>& line,
                          const typename Scene<S>::Observation& seen, bool depth) -> Vec<double, 2> {
    const Plucker<double> in_cam = (pose * scene.T_body_cam).inverse() * (T_world_anchor * line.plucker());
    return depth ? test::depth_of(seen).residual(in_cam) : test::pixels_of(seen).residual(in_cam);
  };
  const Line3<double> line = original.geometry.line.template cast<double>();
  for (const bool depth : {false, true}) {
    if (depth && !original.current.has_depth()) continue;
    const auto of_pose = [&](const SE3<double>& pose) { return errors(pose, line, original.current, depth); };
    const auto of_line = [&](const Line3<double>& x) { return errors(T, x, original.current, depth); };
    const Mat<double, 2, 4> J_line = testing::numeric_jacobian<2, 4>(of_line, line, 1e-5);
    const Mat<double, 2, 2> covariance =
        (depth ? original.current.depth.get().covariance : original.current.pixels.covariance).template cast<double>() +
        J_line * original.geometry.covariance.template cast<double>() * J_line.transpose();
    const Mat<double, 2, 6> J = testing::numeric_jacobian<2, 6>(of_pose, T, 1e-5);
    const Mat<double, 2, 2> information = covariance.inverse();
    const Vec<double, 2> r = of_pose(T);
    const double s = r.dot(information * r), w = loss.weight(s);
    H += w * J.transpose() * information * J;
    b += w * J.transpose() * information * r;
    cost += loss.rho(s) / 2;
  }
}

/// The gate, by the errors at a pose.
auto gate(auto& scene, const auto& body, auto chi2) {
  DenseNormalEquations<decltype(chi2), 6> system;
  scene.terms->accumulate(scene.rig, body, system);
  return scene.terms->gate(*scene.store, chi2);
}

}  // namespace

TEMPLATE_TEST_CASE("motion_terms (lines): information, gradient and cost are those of numeric derivatives", "", float,
                   double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 2e-2 : 1e-5;
  Scene<S> scene(10);
  scene.store->landmarks()[1].current.clear_depth();
  scene.store->landmarks()[2].located = false;
  scene.store->landmarks()[3].current.valid = false;
  scene.collect();
  REQUIRE(scene.terms->size() == 8);
  Mat<double, 6, 6> H = Mat<double, 6, 6>::Zero();
  Vec<double, 6> b = Vec<double, 6>::Zero();
  double cost = 0;
  for (const auto& landmark : scene.store->landmarks()) {
    if (landmark.located && landmark.current.valid) add_reference(scene, landmark, scene.T, H, b, cost);
  }
  DenseNormalEquations<S, 6> system;
  scene.terms->accumulate(scene.rig, scene.body(scene.T), system);
  // Each parameter in units of its own information, so that no block hides behind another one.
  const Vec<double, 6> unit = H.diagonal().cwiseSqrt().cwiseInverse();
  const Mat<double, 6, 6> difference = unit.asDiagonal() * (system.H().template cast<double>() - H) * unit.asDiagonal();
  REQUIRE(difference.norm() < tolerance);
  REQUIRE((unit.asDiagonal() * (system.b().template cast<double>() - b)).norm() <
          tolerance * (unit.asDiagonal() * b).norm());
  REQUIRE(std::abs(double(system.cost()) - cost) < tolerance * cost);
}

TEST_CASE("motion_terms (lines): exact lines give the exact pose, and the gate lets all of them pass") {
  Scene<double> scene(12, 0);
  scene.collect();
  SE3<double> T = scene.T;
  for (int i = 0; i < 6; ++i) {
    DenseNormalEquations<double, 6> system;
    scene.terms->accumulate(scene.rig, scene.body(T), system);
    Vec<double, 6> d;
    REQUIRE(system.solve(d));
    T = plus(T, d);
  }
  REQUIRE(minus(T, scene.T_world_body[3]).norm() < 1e-9);
  REQUIRE(gate(scene, scene.body(T), 13.8) == 12);
}

TEST_CASE("motion_terms (lines): the gate rejects outliers and scales the inliers") {
  Scene<double> scene(12, 3);  // three times the noise that is claimed
  for (auto& landmark : scene.store->landmarks()) landmark.geometry.covariance.setZero();
  auto& wrong = scene.store->landmarks()[4].current;
  testing::Gaussian noise(1);
  wrong = scene.observe(scene.p_world[4] + Vec<double, 3>(0.3, -0.3, 0.1), scene.q_world[4], 3, 0, noise);
  auto& broken = scene.store->landmarks()[5].current;
  broken.pixels.measured.bearing_start.setConstant(std::numeric_limits<double>::quiet_NaN());
  const Mat<double, 2, 2> L = scene.store->landmarks()[0].current.pixels.L;
  scene.collect();
  REQUIRE(gate(scene, scene.body(scene.T_world_body[3]), 13.8) == 10);
  REQUIRE_FALSE(scene.store->landmarks()[4].current.valid);
  REQUIRE_FALSE(scene.store->landmarks()[5].current.valid);
  REQUIRE(scene.store->landmarks()[0].current.valid);
  const double scale = L(0, 0) / scene.store->landmarks()[0].current.pixels.L(0, 0);
  REQUIRE(scale > 1.5);
  REQUIRE(scale < 6);
}

TEST_CASE("motion_terms (lines): nothing seen is no information") {
  Scene<double> scene(3);
  for (auto& landmark : scene.store->landmarks()) landmark.current.valid = false;
  scene.collect();
  REQUIRE(scene.terms->size() == 0);
  DenseNormalEquations<double, 6> system;
  scene.terms->accumulate(scene.rig, scene.body(scene.T), system);
  REQUIRE(system.H().isZero(0));
  REQUIRE(gate(scene, scene.body(scene.T), 13.8) == 0);
}
