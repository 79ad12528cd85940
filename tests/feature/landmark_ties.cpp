// What ties the kinds of a window: which line holds which point, and a step of everything against a dense solution with
// numeric Jacobians.                                                   docs/math/collinear.md, docs/math/solver.md (13)
#include "plumbline/feature/landmark_ties.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <memory>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "feature/seen_collinear.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/window_terms.hpp"
#include "plumbline/feature/window_views.hpp"
#include "plumbline/residual/collinear_point.hpp"
#include "plumbline/solver/normal_equations.hpp"

using namespace plumbline;

namespace {

using VecX = Eigen::VectorXd;
using MatX = Eigen::MatrixXd;

struct Scene : test::SeenCollinear<double> {
  using Set = LandmarkSet<Store, LineStore>;
  using Equations = NormalEquations<double, 6, slots>;
  static constexpr int points = count * on_each, lines_at = 6 * used + points, dim = lines_at + 4 * count;
  static constexpr double pose_information = 10;

  std::unique_ptr<Set> set = std::make_unique<Set>(StoreOptions{}, StoreOptions{});
  std::unique_ptr<LandmarkTies<Set>> ties = std::make_unique<LandmarkTies<Set>>();
  std::unique_ptr<Set::TupleOf<WindowTerms>> terms = std::make_unique<Set::TupleOf<WindowTerms>>();
  WindowViews<double, slots> views;
  WindowTerms<Store>::Pairs pairs;

  Scene() {
    set->get<0>() = *store;
    set->get<1>() = *lines;
    update();
  }
  auto& of_points() { return set->get<0>().landmarks(); }
  auto& of_lines() { return set->get<1>().landmarks(); }
  void update() {
    views.update(window, T_body_cam);
    views.set_transports(window, pairs);
  }
  /// Everything a little beside the truth.
  void disturb() {
    for (int k = 0; k < used; ++k) {
      Vec<double, 6> e;
      e << 2e-4 * noise.vector<3>(), 4e-4 * noise.vector<3>();
      window.state(k).add(e);
    }
    for (auto& point : of_points()) point.geometry.inverse_range *= 1 + 1e-3 * noise();
    for (auto& line : of_lines())
      line.geometry.line = line.geometry.line.plus(Vec<double, 4>(3e-4 * noise.vector<4>()));
    update();
  }

  struct Moved {
    std::vector<SE3<double>> T_world_cam;
    std::vector<double> lambda;
    std::vector<Line3<double>> line;
  };
  /// Frames, inverse ranges and lines moved by their parts of d.
  Moved moved(const VecX& d) {
    Moved out;
    for (int k = 0; k < used; ++k)
      out.T_world_cam.push_back(plus(window.T_world_body(k), Vec<double, 6>(d.segment<6>(6 * k))) * T_body_cam);
    for (int i = 0; i < points; ++i)
      out.lambda.push_back(of_points()[std::size_t(i)].geometry.inverse_range + d[6 * used + i]);
    for (int i = 0; i < count; ++i)
      out.line.push_back(of_lines()[std::size_t(i)].geometry.line.plus(Vec<double, 4>(d.segment<4>(lines_at + 4 * i))));
    return out;
  }
  /// All whitened residuals at `at`; those of the ties are the last 2 * points, point i on line i / on_each.
  VecX residuals(const Moved& at) {
    std::vector<double> out;
    const auto add = [&](const Vec<double, 2>& r) { out.insert(out.end(), {r[0], r[1]}); };
    const auto T = [&](int to, int from) {
      return at.T_world_cam[std::size_t(to)].inverse() * at.T_world_cam[std::size_t(from)];
    };
    for (int i = 0; i < points; ++i) {
      const auto& point = of_points()[std::size_t(i)];
      for (int k = 0; k < used; ++k) {
        const auto& seen = point.observations[std::size_t(k)];
        if (k == point.anchor || !seen.valid) continue;
        const Vec<double, 3> P =
            T(k, point.anchor) * Vec<double, 3>(point.geometry.bearing / at.lambda[std::size_t(i)]);
        add(seen.L.cast<double>() * (rig.vision.camera.project(P).uv - seen.uv.cast<double>()));
      }
    }
    for (int i = 0; i < count; ++i) {
      const auto& line = of_lines()[std::size_t(i)];
      for (int k = 0; k < used; ++k) {
        const auto& seen = line.observations[std::size_t(k)];
        if (!seen.valid) continue;
        const Vec<double, 3> n = (T(k, line.anchor) * at.line[std::size_t(i)].plucker()).n.normalized();
        const auto& pixels = seen.pixels.measured;
        add(seen.pixels.L * Vec<double, 2>(pixels.px_per_rad[0] * n.dot(pixels.bearing_start),
                                           pixels.px_per_rad[1] * n.dot(pixels.bearing_end)));
      }
    }
    for (int i = 0; i < points; ++i) {
      const auto& point = of_points()[std::size_t(i)];
      const std::size_t l = std::size_t(i / on_each);
      const double lambda = at.lambda[std::size_t(i)];
      const Vec<double, 3> P = T(of_lines()[l].anchor, point.anchor) * Vec<double, 3>(point.geometry.bearing / lambda);
      add(CollinearPoint<double>::residual(at.line[l], lambda * P, lambda) / 0.003);
    }
    return Eigen::Map<VecX>(out.data(), Eigen::Index(out.size()));
  }

  /// lambda * distance to the line, by sigma.
  double error(std::size_t p, std::size_t l, double sigma = 0.003) {
    const auto& point = of_points()[p];
    const auto& line = of_lines()[l];
    const SE3<double> T =
        (window.T_world_body(line.anchor) * T_body_cam).inverse() * (window.T_world_body(point.anchor) * T_body_cam);
    const Vec<double, 3> P = T * Vec<double, 3>(point.geometry.bearing / point.geometry.inverse_range);
    const Vec<double, 3> to_point = P - line.geometry.line.closest_point();
    return point.geometry.inverse_range * to_point.cross(line.geometry.line.direction()).norm() / sigma;
  }
  double cost() { return ties->cost(*set, views); }
};

/// The line of `geometry` moved across by `distance` [m], away from the camera's axis.
Line3<double> shifted(const Line3<double>& line, double distance) {
  const Vec<double, 3> c = line.closest_point(), d = line.direction();
  const Vec<double, 3> across = d.cross(c).normalized();
  return Line3<double>::through(c + distance * across, c + distance * across + d);
}

}  // namespace

TEST_CASE("landmark_ties: the step of frames, points and lines is that of the dense equations") {
  const bool without_residuals = GENERATE(false, true);
  Scene scene;
  scene.disturb();
  scene.ties->choose(*scene.set, scene.views);

  // Dense: J by central differences; damping of the lines as in line.md (31).
  const VecX zero = VecX::Zero(Scene::dim);
  VecX r = scene.residuals(scene.moved(zero));
  REQUIRE(r.cwiseAbs().maxCoeff() < 1.7);  // all kernels are quadratic there
  REQUIRE(r.tail(2 * Scene::points).cwiseAbs().maxCoeff() > 0.1);
  MatX J(r.size(), Scene::dim);
  for (int c = 0; c < Scene::dim; ++c) {
    const VecX d = 1e-6 * VecX::Unit(Scene::dim, c);
    J.col(c) = (scene.residuals(scene.moved(d)) - scene.residuals(scene.moved(-d))) / 2e-6;
  }
  if (without_residuals) r.tail(2 * Scene::points).setZero();
  VecX prior = VecX::Zero(Scene::dim);
  prior.head(6 * Scene::used).setConstant(Scene::pose_information);
  prior.tail(4 * Scene::count).setConstant(1);
  const MatX H = J.transpose() * J + MatX(prior.asDiagonal());
  const VecX b = J.transpose() * r, d_dense = -H.ldlt().solve(b);

  // The same by elimination.
  scene.pairs.reset();
  double cost = 0;
  scene.set->for_each_with(*scene.terms, [&](auto& store, auto& terms) {
    cost += terms.linearize(scene.rig, store, scene.window, scene.views, scene.pairs);
  });
  const double of_ties = scene.ties->linearize(*scene.set, scene.views);
  if (!without_residuals) {
    CHECK(of_ties == Approx(r.tail(2 * Scene::points).squaredNorm() / 2).epsilon(1e-9));
    CHECK(cost + of_ties == Approx(r.squaredNorm() / 2).epsilon(1e-4));  // pixels are float
    CHECK(scene.cost() == Approx(of_ties).epsilon(1e-9));
  } else {
    scene.ties->clear_residuals();
  }
  Scene::Equations equations;
  equations.reset(Scene::slots);
  for (int k = 0; k < Scene::slots; ++k) {
    equations.add_block(k, k, Mat<double, 6, 6>(Scene::pose_information * Mat<double, 6, 6>::Identity()));
  }
  scene.pairs.add_to(equations);
  scene.set->for_each_with(
      *scene.terms, [&](auto& store, auto& terms) { REQUIRE(terms.eliminate(store, 0, scene.pairs, equations)); });
  scene.ties->eliminate(*scene.set, *scene.terms, scene.pairs, equations);
  Scene::Equations::Vector d;
  REQUIRE(equations.solve(0, d));
  double predicted = equations.predicted_decrease(0, d);
  scene.set->for_each_with(*scene.terms,
                           [&](auto& store, auto& terms) { predicted += terms.solve(store, scene.pairs, d, 6); });
  predicted += scene.ties->solve(*scene.terms, d, 6);

  VecX found = zero;
  found.head(6 * Scene::used) = d.head(6 * Scene::used);
  for (int i = 0; i < Scene::points; ++i) found[6 * Scene::used + i] = std::get<0>(*scene.terms).step_of(i)[0];
  for (int i = 0; i < Scene::count; ++i)
    found.segment<4>(Scene::lines_at + 4 * i) = std::get<1>(*scene.terms).step_of(i);
  const auto difference = [&](int at, int n) {
    return (found.segment(at, n) - d_dense.segment(at, n)).norm() / d_dense.segment(at, n).norm();
  };
  CHECK(difference(0, 6 * Scene::used) < 1e-4);
  CHECK(difference(6 * Scene::used, Scene::points) < 1e-4);
  CHECK(difference(Scene::lines_at, 4 * Scene::count) < 1e-4);
  CHECK(predicted == Approx(-b.dot(d_dense) / 2).epsilon(1e-4));
}

TEST_CASE("landmark_ties: a point at a corner is tied to the better line, in whatever order the lines are") {
  Scene scene;
  const bool first_is_better = GENERATE(true, false);
  constexpr std::size_t a = 0, b = 2, p = 0;  // lines of one anchor, the first point of the one
  auto& lines = scene.of_lines();
  const double range = 1 / scene.of_points()[p].geometry.inverse_range;
  const Line3<double> through = lines[a].geometry.line;
  const double near_m = 0.7 * 0.003 * range, far_m = 1.9 * 0.003 * range;
  lines[a].geometry.line = shifted(through, first_is_better ? near_m : far_m);
  lines[b].geometry.line = shifted(through, first_is_better ? -far_m : -near_m);
  for (std::size_t i = 0; i < lines.size(); ++i) lines[i].appearance.points.clear();
  lines[a].appearance.points.push_back({.id = scene.of_points()[p].id});
  lines[b].appearance.points.push_back({.id = scene.of_points()[p].id});
  const double of_a = scene.error(p, a), of_b = scene.error(p, b);
  CAPTURE(of_a, of_b);
  REQUIRE(std::min(of_a, of_b) > 0.3);
  REQUIRE(std::max(of_a, of_b) > 1.5 * std::min(of_a, of_b));
  REQUIRE(std::max(of_a, of_b) < 2.4);
  REQUIRE((of_a < of_b) == first_is_better);

  scene.ties->choose(*scene.set, scene.views);
  const double better = std::min(of_a, of_b);
  CHECK(scene.cost() == Approx(better * better / 2).epsilon(1e-9));
  // It stays with that line until the next choice, and with that line alone.
  const std::size_t chosen = first_is_better ? a : b, other = first_is_better ? b : a;
  lines[other].geometry.line = through;
  CHECK(scene.cost() == Approx(better * better / 2).epsilon(1e-9));
  lines[chosen].geometry.line = shifted(through, 2 * near_m);
  const double moved = scene.error(p, chosen);
  CHECK(scene.cost() == Approx(moved * moved / 2).epsilon(1e-9));
  scene.ties->choose(*scene.set, scene.views);
  CHECK(scene.cost() < 1e-6);  // now the other one is better
}

TEST_CASE("landmark_ties: a point that is beside its line counts as less") {
  Scene scene;
  auto& lines = scene.of_lines();
  for (std::size_t i = 0; i < lines.size(); ++i) lines[i].appearance.points.clear();
  const double offset = 0.004;
  lines[0].appearance.points.push_back({.id = scene.of_points()[0].id, .offset = offset});
  scene.ties->choose(*scene.set, scene.views);
  // The point is on the line, so all of the offset is error.
  const double expected = offset * offset / (0.003 * 0.003 + offset * offset) / 2;
  CHECK(scene.cost() == Approx(expected).epsilon(1e-3));
}

TEST_CASE("landmark_ties: the kind that is held is the first that can be, and without one there is nothing") {
  Scene scene;
  scene.disturb();
  scene.ties->choose(*scene.set, scene.views);
  const double cost = scene.cost();
  REQUIRE(cost > 0.1);

  using OtherLines = LandmarkStore<LineKind<Scene::Sensors>, 4, Scene::slots>;
  using Three = LandmarkSet<OtherLines, Scene::Store, Scene::LineStore>;
  STATIC_REQUIRE(LandmarkTies<Three>::any);
  const auto three = std::make_unique<Three>(StoreOptions{}, StoreOptions{}, StoreOptions{});
  three->get<1>() = scene.set->get<0>();
  three->get<2>() = scene.set->get<1>();
  const auto ties = std::make_unique<LandmarkTies<Three>>();
  ties->choose(*three, scene.views);
  CHECK(ties->cost(*three, scene.views) == cost);

  using Alone = LandmarkSet<Scene::Store, OtherLines>;
  STATIC_REQUIRE((!LandmarkTies<Alone>::any && std::is_empty_v<LandmarkTies<Alone>>));
  const auto alone = std::make_unique<Alone>(StoreOptions{}, StoreOptions{});
  alone->get<0>() = scene.set->get<0>();
  LandmarkTies<Alone> none;
  none.choose(*alone, scene.views);
  CHECK(none.linearize(*alone, scene.views) + none.cost(*alone, scene.views) == 0);
}
