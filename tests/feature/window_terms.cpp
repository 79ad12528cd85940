// What holds for every kind: rows are those of the residual types, and what is no number costs more than what is.
#include "plumbline/feature/window_terms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <type_traits>

#include "catch.hpp"
#include "feature/residuals_of.hpp"
#include "feature/seen_lines.hpp"
#include "feature/seen_points.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/solver/normal_equations.hpp"

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
  using Terms = WindowTerms<typename Seen::Store>;
  using Equations = NormalEquations<double, state::Pose::dim, Seen::slots>;
  static constexpr int pose_dim = state::Pose::dim * Seen::slots;

  WindowViews<S, Seen::slots> views;
  typename Terms::Pairs pairs;
  std::unique_ptr<Terms> terms = std::make_unique<Terms>();

  explicit Scene(int count) : Seen(count) { update(); }
  void update() {
    views.update(Seen::window, Seen::T_body_cam.template cast<S>());
    views.set_transports(Seen::window, pairs);
  }
  double linearize() {
    pairs.reset();
    return terms->linearize(Seen::rig, *Seen::store, Seen::window, views, pairs);
  }
  double cost() const { return terms->cost(Seen::rig, *Seen::store, Seen::window, views); }
  auto& landmarks() { return Seen::store->landmarks(); }
};

template <class S>
constexpr double tolerance = std::is_same_v<S, float> ? 2e-4 : 1e-12;

}  // namespace

#define SCENES                                                                                                       \
  SeenPoints<float>, SeenPoints<double>, (SeenPoints<double, MonoRig<double>>), SeenLines<float>, SeenLines<double>, \
      (SeenLines<double, MonoRig<double>>)

TEMPLATE_TEST_CASE("window_terms: the poses' equations are the sum of the residuals', both poses by their Jacobians",
                   "", SCENES) {
  using Seen = TestType;
  Scene<Seen> scene(8);
  using S = typename Scene<Seen>::S;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(scene.pose_dim, scene.pose_dim);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(scene.pose_dim);
  int residuals = 0;
  for (const auto& landmark : scene.landmarks()) {
    for (int slot = 0; slot < scene.used; ++slot) {
      const auto& seen = landmark.observations[std::size_t(slot)];
      if (!seen.valid || slot == landmark.anchor) continue;
      test::for_each_view_residual(
          typename Seen::Kind{}, scene.rig, landmark.geometry, seen, scene.views(landmark.anchor, slot),
          [&](const auto& lin, const auto& L, const Huber<S>& loss) {
            REQUIRE(lin.valid);
            ++residuals;
            const Eigen::VectorXd r = (L * lin.r).template cast<double>();
            Eigen::MatrixXd J = Eigen::MatrixXd::Zero(r.size(), scene.pose_dim);
            J.middleCols(6 * landmark.anchor, 6) = (L * lin.J_r_anchor).template cast<double>();
            J.middleCols(6 * slot, 6) = (L * lin.J_r_target).template cast<double>();
            const double w = double(loss.weight(S(r.squaredNorm())));
            H += w * J.transpose() * J;
            b += w * J.transpose() * r;
          });
    }
  }
  REQUIRE(residuals >= 8 * 2);
  scene.linearize();
  typename Scene<Seen>::Equations equations;
  equations.reset(scene.slots);
  scene.pairs.add_to(equations);
  const Eigen::MatrixXd found = equations.H().template selfadjointView<Eigen::Lower>();
  REQUIRE((found - H).norm() < tolerance<S> * H.norm());
  REQUIRE((equations.b() - b).norm() < tolerance<S> * b.norm());
}

TEMPLATE_TEST_CASE("window_terms: a landmark's covariance is that of the residuals by the landmark", "", SCENES) {
  using Seen = TestType;
  using Kind = typename Seen::Kind;
  Scene<Seen> scene(1);
  using S = typename Scene<Seen>::S;
  auto& landmark = scene.landmarks()[0];
  // The anchor's own rows are left out by taking away what it measured besides its defining pixels.
  Mat<double, Kind::dim, Kind::dim> information = Mat<double, Kind::dim, Kind::dim>::Zero();
  constexpr bool is_line = Kind::dim == 4;
  if constexpr (is_line) information.setIdentity();  // what holds it in a step
  const auto add = [&](const auto& J_l, const auto& r, const auto& L, const Huber<S>& loss) {
    const auto J = (L * J_l).eval();
    const double w = double(loss.weight((L * r).squaredNorm()));
    information += w * (J.transpose() * J).template cast<double>();
  };
  for (int slot = 0; slot < scene.used; ++slot) {
    const auto& seen = landmark.observations[std::size_t(slot)];
    REQUIRE(seen.valid);
    // The anchor sees itself from no distance.
    const RelativeView<S> self(scene.window.T_world_body(0), scene.window.T_world_body(0),
                               scene.T_body_cam.template cast<S>());
    const bool in_anchor = slot == landmark.anchor;
    test::for_each_view_residual(Kind{}, scene.rig, landmark.geometry, seen,
                                 in_anchor ? self : scene.views(landmark.anchor, slot),
                                 [&](const auto& lin, const auto& L, const Huber<S>& loss) {
                                   const bool defines = in_anchor && !is_line && lin.r.size() == 2;
                                   if (!defines) add(lin.J_r_lambda, lin.r, L, loss);
                                 });
  }
  scene.terms->finish(scene.rig, *scene.store, scene.window, scene.views, scene.pairs);
  REQUIRE(landmark.located);
  Mat<double, Kind::dim, Kind::dim> covariance;
  if constexpr (is_line) {
    covariance = landmark.geometry.covariance.template cast<double>();
  } else {
    covariance(0, 0) = std::pow(double(landmark.geometry.sigma_inverse_range), 2);
  }
  const auto I = Mat<double, Kind::dim, Kind::dim>::Identity();
  REQUIRE((covariance * information - I).norm() < (std::is_same_v<S, float> ? 2e-2 : 1e-9));
}

TEMPLATE_TEST_CASE("window_terms: the cost alone is that of the linearization", "", SCENES) {
  Scene<TestType> scene(12);
  const double cost = scene.linearize();
  REQUIRE(cost > 0);
  REQUIRE(scene.cost() == Approx(cost).epsilon(1e-5));
}

TEMPLATE_TEST_CASE("window_terms: steps are made and taken back to the last bit", "", SCENES) {
  using Seen = TestType;
  Scene<Seen> scene(8);
  scene.linearize();
  typename Scene<Seen>::Equations equations;
  equations.reset(scene.slots);
  REQUIRE(scene.terms->eliminate(*scene.store, typename Scene<Seen>::S(1e-3), scene.pairs, equations));
  const double before = scene.cost(), predicted = scene.terms->solve(*scene.store, scene.pairs,
                                                                     Eigen::VectorXd::Zero(scene.pose_dim).eval(), 6);
  REQUIRE(predicted > 0);
  scene.terms->step(*scene.store);
  const double after = scene.cost();
  REQUIRE(after < before);
  if (Seen::Sensors::has_depth) REQUIRE(before - after == Approx(predicted).epsilon(0.5));  // far from linear else
  scene.terms->restore(*scene.store);
  REQUIRE(scene.cost() == before);
}

TEMPLATE_TEST_CASE("window_terms: in the end what is left is linearized", "", SCENES) {
  using Seen = TestType;
  Scene<Seen> scene(6);
  scene.landmarks()[0].located = false;
  auto& unseen = scene.landmarks()[1];
  for (int k = 0; k < scene.used; ++k) unseen.observations[std::size_t(k)].valid = k == unseen.anchor;
  const auto equations = [&] {
    auto out = std::make_unique<typename Scene<Seen>::Equations>();
    out->reset(scene.slots);
    scene.pairs.add_to(*out);
    REQUIRE(scene.terms->eliminate(*scene.store, typename Scene<Seen>::S(1e-3), scene.pairs, *out));
    return out;
  };
  scene.linearize();  // what is added to it must not remain
  scene.pairs.reset();
  scene.terms->finish(scene.rig, *scene.store, scene.window, scene.views, scene.pairs);
  const auto in_the_end = equations();
  scene.linearize();
  const auto again = equations();
  REQUIRE(again->b().norm() > 0);
  REQUIRE(in_the_end->H() == again->H());
  REQUIRE(in_the_end->b() == again->b());
}

TEMPLATE_TEST_CASE("window_terms: landmarks that take no part add nothing and are not moved", "", SCENES) {
  using Seen = TestType;
  Scene<Seen> scene(3);
  scene.landmarks()[0].located = false;
  auto& alone = scene.landmarks()[1];
  for (int k = 0; k < scene.used; ++k) alone.observations[std::size_t(k)].valid = k == alone.anchor;
  auto& without_anchor = scene.landmarks()[2];
  without_anchor.observations[std::size_t(without_anchor.anchor)].valid = false;
  REQUIRE(scene.linearize() == 0);
  REQUIRE(scene.cost() == 0);
  typename Scene<Seen>::Equations equations;
  equations.reset(scene.slots);
  scene.pairs.add_to(equations);
  REQUIRE(scene.terms->eliminate(*scene.store, typename Scene<Seen>::S(0), scene.pairs, equations));
  REQUIRE(equations.b().isZero(0));
  REQUIRE(scene.terms->solve(*scene.store, scene.pairs, Eigen::VectorXd::Ones(scene.pose_dim).eval(), 6) == 0);
  scene.terms->step(*scene.store);
  scene.terms->for_each_leaving(1, scene.rig, *scene.store, scene.window, scene.views,
                                [](const auto&, const auto&) { FAIL("nothing leaves"); });
}

TEMPLATE_TEST_CASE("window_terms: what leaves was part of the last solution", "", SCENES) {
  using Seen = TestType;
  Scene<Seen> scene(6);
  const auto leaving = [&] {
    int n = 0;
    scene.terms->for_each_leaving(0, scene.rig, *scene.store, scene.window, scene.views,
                                  [&](const auto&, const auto&) { ++n; });
    return n;
  };
  for (auto& landmark : scene.landmarks()) landmark.solved = false;  // as when they have just been located
  CHECK(leaving() == 0);
  scene.linearize();
  scene.pairs.reset();
  scene.terms->finish(scene.rig, *scene.store, scene.window, scene.views, scene.pairs);
  const int all = leaving();
  CHECK(all > 2);
  auto& anchored = *std::find_if(scene.landmarks().begin(), scene.landmarks().end(),
                                 [](const auto& landmark) { return landmark.anchor == 0 && landmark.takes_part(); });
  anchored.solved = false;
  CHECK(leaving() == all - 1);
  anchored.located = false;  // and by the next solution it is none
  scene.linearize();
  scene.pairs.reset();
  scene.terms->finish(scene.rig, *scene.store, scene.window, scene.views, scene.pairs);
  anchored.located = true;
  CHECK(leaving() == all - 1);
}

TEMPLATE_TEST_CASE("window_terms: frames that are no longer in the window are not asked", "", SCENES) {
  Scene<TestType> scene(6);
  const double all = scene.linearize();
  for (auto& landmark : scene.landmarks()) landmark.observations[4] = landmark.observations[3];  // of a free slot
  REQUIRE(scene.linearize() == all);
  REQUIRE(scene.cost() == Approx(all).epsilon(1e-5));
}

TEMPLATE_TEST_CASE("window_terms: a state that is no number never costs less", "", SCENES) {
  using Seen = TestType;
  using S = typename Scene<Seen>::S;
  Scene<Seen> scene(6);
  const double before = scene.cost();
  scene.window.state(2).add(Vec<S, 6>::Constant(std::numeric_limits<S>::quiet_NaN()));
  scene.update();
  REQUIRE_FALSE(scene.cost() < before);
}
