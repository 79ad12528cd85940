// What holds for every kind: rows are those of the residual types, and only what the latest frame sees counts.
#include "plumbline/feature/motion_terms.hpp"

#include <limits>
#include <memory>
#include <type_traits>

#include "catch.hpp"
#include "feature/residuals_of.hpp"
#include "feature/seen_lines.hpp"
#include "feature/seen_points.hpp"
#include "plumbline/sensor/mono.hpp"

using namespace plumbline;
using test::SeenLines;
using test::SeenPoints;

namespace {

template <class S>
using MonoRig = Rig<Mono<Pinhole<S>, 64 * 64>>;

template <class Seen>
struct Scene : Seen {
  using Kind = typename Seen::Kind;
  using S = typename Kind::Scalar;
  using Terms = MotionTerms<typename Seen::Store>;
  std::unique_ptr<Terms> terms = std::make_unique<Terms>();
  SE3<S> T_body_cam_s;

  explicit Scene(int count) : Seen(count), T_body_cam_s(Seen::T_body_cam.template cast<S>()) {}
  void collect() { terms->collect(*Seen::store, Seen::window, T_body_cam_s); }
  BodyView<S> body(const SE3<S>& T) const { return {T, T_body_cam_s}; }
  SE3<S> T_latest() const { return Seen::window.T_world_body(Seen::used - 1); }
  auto& landmarks() { return Seen::store->landmarks(); }
};

void forget_uncertainty(auto& geometry) {
  if constexpr (requires { geometry.sigma_inverse_range; }) {
    geometry.sigma_inverse_range = 0;
  } else {
    geometry.covariance.setZero();
  }
}

/// The gate, by the errors at a pose.
auto gate(auto& scene, const auto& body, auto chi2) {
  DenseNormalEquations<decltype(chi2), 6> system;
  scene.terms->accumulate(scene.rig, body, system);
  return scene.terms->gate(*scene.store, chi2);
}

}  // namespace

#define SCENES                                                                                                       \
  SeenPoints<float>, SeenPoints<double>, (SeenPoints<double, MonoRig<double>>), SeenLines<float>, SeenLines<double>, \
      (SeenLines<double, MonoRig<double>>)

TEMPLATE_TEST_CASE("motion_terms: the pose's equations are the sum of the residuals'", "", SCENES) {
  using Seen = TestType;
  using S = typename Scene<Seen>::S;
  const S tolerance = std::is_same_v<S, float> ? S(2e-4) : S(1e-12);
  Scene<Seen> scene(10);
  for (auto& landmark : scene.landmarks()) forget_uncertainty(landmark.geometry);
  const SE3<S> T = plus(scene.T_latest(), Vec<S, 6>(Vec<S, 6>::Constant(S(2e-3))));
  Mat<S, 6, 6> H = Mat<S, 6, 6>::Zero();
  Vec<S, 6> b = Vec<S, 6>::Zero();
  S cost = 0;
  for (const auto& landmark : scene.landmarks()) {
    test::for_each_world_residual(typename Seen::Kind{}, scene.rig, landmark.geometry, landmark.current,
                                  scene.window.T_world_body(landmark.anchor) * scene.T_body_cam_s, scene.body(T),
                                  [&](const auto& lin, const auto& L, const Huber<S>& loss) {
                                    REQUIRE(lin.valid);
                                    const auto r = (L * lin.r).eval();
                                    const auto J = (L * lin.J_r_pose).eval();
                                    const S w = loss.weight(r.squaredNorm());
                                    H += w * J.transpose() * J;
                                    b += w * J.transpose() * r;
                                    cost += loss.rho(r.squaredNorm()) / 2;
                                  });
  }
  scene.collect();
  REQUIRE(scene.terms->size() == scene.landmarks().size());
  DenseNormalEquations<S, 6> system;
  scene.terms->accumulate(scene.rig, scene.body(T), system);
  REQUIRE((system.H() - H).norm() < tolerance * H.norm());
  REQUIRE((system.b() - b).norm() < tolerance * b.norm());
  REQUIRE(double(system.cost()) == Approx(double(cost)).epsilon(double(tolerance)));
}

TEMPLATE_TEST_CASE("motion_terms: an uncertain landmark weighs less, never more", "", SCENES) {
  using Seen = TestType;
  using S = typename Scene<Seen>::S;
  Scene<Seen> scene(1);
  const auto information = [&](S sigma) {
    auto& geometry = scene.landmarks()[0].geometry;
    if constexpr (requires { geometry.sigma_inverse_range; }) {
      geometry.sigma_inverse_range = sigma;
    } else {
      geometry.covariance = sigma * sigma * Mat<S, 4, 4>::Identity();
    }
    scene.collect();
    DenseNormalEquations<S, 6> system;
    scene.terms->accumulate(scene.rig, scene.body(scene.T_latest()), system);
    return system.H().trace();
  };
  const S none = information(S(0)), some = information(S(0.01)), much = information(S(0.1));
  REQUIRE(some < none);
  REQUIRE(much < some);
  REQUIRE(much > 0);
}

TEMPLATE_TEST_CASE("motion_terms: only located landmarks that the latest frame sees", "", SCENES) {
  Scene<TestType> scene(8);
  scene.landmarks()[2].located = false;
  scene.landmarks()[5].current.valid = false;
  scene.collect();
  REQUIRE(scene.terms->size() == 6);
  REQUIRE(gate(scene, scene.body(scene.T_latest()), typename Scene<TestType>::S(1000)) == 6);
  REQUIRE(scene.landmarks()[2].current.valid);  // it was not used
}

TEMPLATE_TEST_CASE("motion_terms: what does not fit leaves the frame and is on record", "", SCENES) {
  using Seen = TestType;
  using S = typename Scene<Seen>::S;
  Scene<Seen> scene(10);
  auto& wrong = scene.landmarks()[3].current;
  if constexpr (requires { wrong.uv; }) {
    wrong.uv.x() += 40;
  } else {
    wrong.pixels.measured.bearing_start += Vec<S, 3>(S(0.1), S(-0.1), 0);
  }
  scene.collect();
  const int kept = gate(scene, scene.body(scene.T_latest()), S(13.8));
  REQUIRE_FALSE(scene.landmarks()[3].current.valid);
  REQUIRE(kept == scene.store->seen_count());
  REQUIRE(kept >= 8);
  REQUIRE(int(scene.store->rejected().size()) == 10 - kept);
}

TEMPLATE_TEST_CASE("motion_terms: a pose that is no number keeps nothing", "", SCENES) {
  using Seen = TestType;
  using S = typename Scene<Seen>::S;
  Scene<Seen> scene(8);
  scene.collect();
  const SE3<S> T(SO3<S>(), Vec<S, 3>::Constant(std::numeric_limits<S>::quiet_NaN()));
  DenseNormalEquations<S, 6> system;
  scene.terms->accumulate(scene.rig, scene.body(T), system);
  Vec<S, 6> d;
  REQUIRE_FALSE(system.solve(d));
  REQUIRE(gate(scene, scene.body(T), S(13.8)) == 0);
  REQUIRE(scene.store->seen_count() == 0);
}

TEMPLATE_TEST_CASE("motion_terms: a frame that sees nothing", "", SCENES) {
  Scene<TestType> scene(0);
  scene.collect();
  REQUIRE(scene.terms->size() == 0);
  REQUIRE(gate(scene, scene.body(scene.T_latest()), typename Scene<TestType>::S(13.8)) == 0);
}
