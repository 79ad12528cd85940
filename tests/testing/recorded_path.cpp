#include "plumbline/testing/recorded_path.hpp"

#include "catch.hpp"
#include "plumbline/lie/plus.hpp"

using namespace plumbline;
using namespace plumbline::testing;

namespace {

const SE3<double> first(SO3<double>::exp({0.1, 0, 0}), {1, 2, 3}), second(SO3<double>::exp({0.3, 0, 0}), {3, 1, 4});
const SE3<double> third(SO3<double>::exp({0.3, 0.2, 0}), {2, 5, 3});

RecordedPath path() {
  return RecordedPath({{1'000'000'000, first}, {2'000'000'000, second}, {4'000'000'000, third}}, 1'500'000'000);
}

}  // namespace

TEST_CASE("recorded_path: poses at, between and beyond the samples") {
  CHECK(minus(path().at(0.5).T_world_body, second).norm() < 1e-12);
  const SE3<double> between(SO3<double>::exp({0.2, 0, 0}), {2, 1.5, 3.5});
  CHECK(minus(path().at(0).T_world_body, between).norm() < 1e-12);
  CHECK(minus(path().at(-9).T_world_body, first).norm() < 1e-12);
  CHECK(minus(path().at(9).T_world_body, third).norm() < 1e-12);
}

TEST_CASE("recorded_path: bounds, and a shift of all poses") {
  RecordedPath moved = path();
  moved.shift({10, 0, -1});
  CHECK((moved.bounds().min - Vec<double, 3>(11, 1, 2)).norm() < 1e-12);
  CHECK((moved.bounds().max - Vec<double, 3>(13, 5, 3)).norm() < 1e-12);
  CHECK(minus(moved.at(0.5).T_world_body.rotation(), second.rotation()).norm() < 1e-12);
}
