// Lines located by the points on them, without images.
#include "plumbline/frontend/collinear_location.hpp"

#include <type_traits>

#include "catch.hpp"
#include "feature/seen_collinear.hpp"

using namespace plumbline;

namespace {

/// Lines that have yet to be located.
template <class S>
struct Scene : test::SeenCollinear<S> {
  using Base = test::SeenCollinear<S>;

  Scene() {
    for (auto& point : Base::store->landmarks())
      point.geometry.sigma_inverse_range = S(0.01) * point.geometry.inverse_range;
  }
  bool locate(std::size_t i) {
    auto& line = Base::lines->landmarks()[i];
    const auto truth = line.geometry.line;
    line.located = false;
    line.geometry = {};
    locate_collinear(Base::T_body_cam.template cast<S>(), Base::window, line, *Base::store);
    error = norm(line.located ? minus(line.geometry.line, truth) : zeros<S, 4>());
    line.geometry.line = truth;
    return line.located;
  }
  auto& point(std::size_t line, std::size_t member) {
    return Base::store->landmarks()[line * std::size_t(Base::on_each) + member];
  }
  S error = S(0);
};

}  // namespace

TEMPLATE_TEST_CASE("collinear_location: exact points give the line", "", float, double) {
  using S = TestType;
  Scene<S> scene;
  for (std::size_t i = 0; i < Scene<S>::count; ++i) {
    REQUIRE(scene.locate(i));
    REQUIRE(scene.error < (std::is_same_v<S, float> ? S(2e-3) : S(1e-8)));
  }
}

TEST_CASE("collinear_location: as good as its points, and not at all where they do not agree on a line") {
  Scene<double> scene;
  for (std::size_t i = 0; i < scene.count; ++i) {
    auto& inverse_range = scene.point(i, 1).geometry.inverse_range;
    inverse_range *= 1.01;  // by one sigma
    REQUIRE(scene.locate(i));
    REQUIRE(scene.error < 0.02);
    inverse_range *= 1.6;
    REQUIRE_FALSE(scene.locate(i));
  }
}

TEST_CASE("collinear_location: not by one point, nor in the plane of points") {
  Scene<double> scene;
  scene.point(0, 0).located = scene.point(0, 2).located = false;
  REQUIRE_FALSE(scene.locate(0));
  auto& line = scene.lines->landmarks()[1];
  line.observations[std::size_t(line.anchor)].from_points = true;
  REQUIRE_FALSE(scene.locate(1));
}
