// Rows of points and their lines in a window, with exact truth at the level of observations.
#include "plumbline/feature/collinear_terms.hpp"

#include <memory>

#include "catch.hpp"
#include "feature/seen_collinear.hpp"
#include "plumbline/feature/window_terms.hpp"
#include "plumbline/feature/window_views.hpp"
#include "plumbline/solver/normal_equations.hpp"

using namespace plumbline;

namespace {

/// Their terms.
template <class S>
struct Scene : test::SeenCollinear<S> {
  using Base = test::SeenCollinear<S>;
  using Base::lines, Base::noise;
  using typename Base::LineStore;
  using LineTerms = WindowTerms<LineStore>;
  using PointTerms = WindowTerms<typename Base::Store>;
  using Terms = CollinearTerms<LineStore, typename Base::Store>;
  using Equations = NormalEquations<double, 6, Base::slots>;

  std::unique_ptr<LineTerms> line_terms = std::make_unique<LineTerms>();
  std::unique_ptr<PointTerms> point_terms = std::make_unique<PointTerms>();
  std::unique_ptr<Terms> terms = std::make_unique<Terms>();
  WindowViews<S, Base::slots> views;
  typename LineTerms::Pairs pairs;

  Scene() { update(); }

  void update() {
    views.update(Base::window, Base::T_body_cam.template cast<S>());
    views.set_transports(Base::window, pairs);
  }
  double linearize() {
    update();
    pairs.reset();
    return point_terms->linearize(Base::rig, *Base::store, Base::window, views, pairs) +
           line_terms->linearize(Base::rig, *lines, Base::window, views, pairs) +
           terms->linearize(*lines, *Base::store, views);
  }
  double cost() {
    update();
    return point_terms->cost(Base::rig, *Base::store, Base::window, views) +
           line_terms->cost(Base::rig, *lines, Base::window, views) + terms->cost(*lines, *Base::store, views);
  }
  /// The step of all, made; the decrease that the linear model promises.
  double step(S mu) {
    Equations equations;
    equations.reset(Base::slots);
    for (int k = 0; k < Base::slots; ++k) {
      equations.add(k, Mat<double, 6, 6>(10 * Mat<double, 6, 6>::Identity()), Vec<double, 6>(Vec<double, 6>::Zero()),
                    1.0);
    }
    pairs.add_to(equations);
    REQUIRE(point_terms->eliminate(*Base::store, mu, pairs, equations));
    REQUIRE(line_terms->eliminate(*lines, mu, pairs, equations));
    terms->eliminate(*lines, *line_terms, *Base::store, *point_terms, pairs, equations);
    typename Equations::Vector d;
    REQUIRE(equations.solve(0, d));
    double predicted = equations.predicted_decrease(0, d);
    predicted += point_terms->solve(*Base::store, pairs, d, 6) + line_terms->solve(*lines, pairs, d, 6);
    predicted += terms->solve(*line_terms, *point_terms, d, 6);
    for (int k = 0; k < Base::used; ++k) {
      Vec<S, 6> d_k;
      for (int c = 0; c < 6; ++c) d_k[c] = S(d[6 * k + c]);
      Base::window.state(k).add(d_k);
      predicted += 50 * d_k.template cast<double>().squaredNorm();  // the rows that hold the poses are no cost here
    }
    point_terms->step(*Base::store);
    line_terms->step(*lines);
    return predicted;
  }
  /// Everything a little beside the truth.
  void disturb(double size) {
    for (int k = 1; k < Base::used; ++k) {
      Vec<double, 6> e;
      e << 0.002 * noise.template vector<3>(), 0.004 * noise.template vector<3>();
      Base::window.state(k).add((size * e).template cast<S>());
    }
    for (auto& point : Base::store->landmarks()) point.geometry.inverse_range *= S(1 + size * 0.01 * noise());
    for (auto& line : lines->landmarks()) {
      line.geometry.line = line.geometry.line.plus((size * 0.003 * noise.template vector<4>()).template cast<S>());
    }
  }
  double distance_to_line(int point) const {
    const auto& p = Base::store->landmarks()[std::size_t(point)];
    const auto& line = lines->landmarks()[std::size_t(point / Base::on_each)];
    return (views_of(p.anchor, line.anchor) * (p.geometry.bearing / p.geometry.inverse_range).template cast<double>() -
            line.geometry.line.closest_point().template cast<double>())
        .cross(line.geometry.line.direction().template cast<double>())
        .norm();
  }
  SE3<double> views_of(int from, int to) const {
    const auto T = [&](int k) { return Base::window.T_world_body(k).template cast<double>() * Base::T_body_cam; };
    return T(to).inverse() * T(from);
  }
};

}  // namespace

TEST_CASE("collinear_terms: a step decreases the cost by as much as it promises") {
  Scene<double> scene;
  scene.terms->choose(*scene.lines, *scene.store, scene.views);
  REQUIRE(scene.cost() < 1e-6);
  // Near to the truth, the quadratic model of everything is the cost itself: rows, elimination and steps all agree.
  for (const double mu : {0.0, 0.01}) {
    Scene<double> near;
    near.disturb(0.01);
    near.update();
    near.terms->choose(*near.lines, *near.store, near.views);
    const double before = near.linearize();
    REQUIRE(before == Approx(near.cost()).epsilon(1e-9));
    const double predicted = near.step(mu), after = near.cost();
    CAPTURE(mu, before, after, predicted);
    REQUIRE(before - after == Approx(predicted).epsilon(0.01));
    REQUIRE(after < before / 2);
  }
}

TEMPLATE_TEST_CASE("collinear_terms: points come to lie on their lines", "", float, double) {
  Scene<TestType> scene;
  scene.disturb(1);
  scene.update();
  scene.terms->choose(*scene.lines, *scene.store, scene.views);
  double largest_before = 0, largest = 0;
  for (int i = 0; i < 18; ++i) largest_before = std::max(largest_before, scene.distance_to_line(i));
  for (int iteration = 0; iteration < 5; ++iteration) {
    scene.linearize();
    scene.step(TestType(0));
  }
  for (int i = 0; i < 18; ++i) largest = std::max(largest, scene.distance_to_line(i));
  CAPTURE(largest_before, largest);
  REQUIRE(largest_before > 0.01);
  REQUIRE(largest < 0.001);
}

TEST_CASE("collinear_terms: a point with weak observations is located by its line") {
  Scene<double> scene;
  auto& point = scene.store->landmarks()[1];  // the middle one of the first line
  for (auto& seen : point.observations) seen.L *= 1e-3f;
  const double truth = point.geometry.inverse_range;
  point.geometry.inverse_range *= 1.2;
  const auto optimize = [&] {
    for (int iteration = 0; iteration < 6; ++iteration) {
      scene.linearize();
      scene.step(0);
    }
  };
  SECTION("with its line") {
    scene.terms->choose(*scene.lines, *scene.store, scene.views);
    optimize();
    REQUIRE(std::abs(point.geometry.inverse_range / truth - 1) < 0.003);
  }
  SECTION("a distant line has no weight") {
    point.geometry.inverse_range = 1.6 * truth;
    scene.terms->choose(*scene.lines, *scene.store, scene.views);
    const double others = scene.linearize();
    point.geometry.inverse_range = 1.7 * truth;
    REQUIRE(std::abs(scene.terms->cost(*scene.lines, *scene.store, scene.views)) < 1e-3 + others);
    optimize();
    REQUIRE(point.geometry.inverse_range > 0);
  }
}

TEST_CASE("collinear_terms: a point at a corner counts for the nearer line") {
  Scene<double> scene;
  auto& lines = scene.lines->landmarks();
  const std::uint32_t id = lines[0].appearance.points[0].id;
  lines[1].appearance.points.push_back({.id = id});  // which is not near
  lines[1].geometry.line = lines[0].anchor == lines[1].anchor ? lines[0].geometry.line : lines[1].geometry.line;
  scene.terms->choose(*scene.lines, *scene.store, scene.views);
  REQUIRE(scene.terms->cost(*scene.lines, *scene.store, scene.views) < 1e-6);
}

TEST_CASE("collinear_terms: a point off the line three times is released") {
  Scene<double> scene;
  scene.store->landmarks()[2].geometry.inverse_range *= 1.3;
  const auto& members = scene.lines->landmarks()[0].appearance.points;
  for (int times = 0; times < 2; ++times) {
    scene.terms->finish(*scene.lines, *scene.store, scene.views);
    REQUIRE(members.size() == 3);
  }
  scene.terms->finish(*scene.lines, *scene.store, scene.views);
  REQUIRE(members.size() == 2);
  for (const auto& member : members) REQUIRE(member.id != scene.store->landmarks()[2].id);
}
