// A keyframe map on laps with known drift: loops close, other places do not, a full map goes on, a new world is joined.
#include "plumbline/map/keyframe_map.hpp"

#include <limits>
#include <memory>

#include "catch.hpp"
#include "laps.hpp"

using namespace plumbline;
using test::Laps;
using test::per_lap;
using test::window;

TEMPLATE_TEST_CASE("keyframe_map: loops correct the drift of an odometry", "", RelativePoseResidual<double>,
                   RelativePoseResidual<float>, RelativePoseYawResidual<float>, RelativeSim3Residual<double>) {
  Laps<TestType> laps(2);
  if (TestType::dim == 4) laps.map->change_world({WorldChange<typename TestType::Scalar>::Kind::transformed, {}, {}});
  for (int k = 0; k < 3 * per_lap - 10; ++k) laps.step();
  CHECK(laps.map->counts().loops > 5);
  CHECK(laps.map->counts().corrections > 5);
  CHECK(laps.world_error() > 0.5);
  CHECK(laps.map_error() < 0.1);
}

TEST_CASE("keyframe_map: the same input gives the same output, bit for bit") {
  Laps<RelativePoseResidual<float>> a(5), b(5);
  for (int k = 0; k < 2 * per_lap; ++k) {
    a.step();
    b.step();
    REQUIRE(a.map->S_map_world().t() == b.map->S_map_world().t());
    REQUIRE(a.map->S_map_world().R() == b.map->S_map_world().R());
  }
  REQUIRE(a.map->counts().corrections > 0);
}

TEST_CASE("keyframe_map: places that are seen once give no loop") {
  Laps<RelativePoseResidual<double>> laps(7);
  for (int k = 0; k < per_lap / 2; ++k) laps.step();
  CHECK(laps.map->counts().queries > 10);
  CHECK(laps.map->counts().loops == 0);
  CHECK(norm(laps.map->S_map_world().t()) == 0);
}

TEST_CASE("keyframe_map: the odometry excludes a place that only looks alike") {
  Laps<RelativePoseResidual<double>> laps(9);
  for (int k = 0; k < per_lap / 2; ++k) laps.step();
  // From here on the camera sees what it saw at the beginning, but its odometry has gone straight on for 30 m.
  laps.drift_rad = 0;
  auto& map = *laps.map;
  for (int k = 0; k < 20; ++k) {
    const SE3<double> T = Laps<RelativePoseResidual<double>>::at(k);
    laps.T_world_body = SE3<double>(laps.T_world_body.rotation(), laps.T_world_body.p() + Vec<double, 3>(1.5, 0, 0));
    Mat<double, 6, 6> covariance = zeros<double, 6, 6>();
    for (int i = 0; i < 6; ++i) covariance(i, i) = 1e-4 * (1 + 0.01 * laps.id);
    ++laps.id;
    auto* keyframe = map.begin_keyframe(laps.id, TimeNs(laps.id), laps.T_world_body, {}, covariance);
    REQUIRE(keyframe);
    laps.places.look(T, keyframe->features);
    map.finish_keyframe();
    map.retire(laps.id - 8, map.places().keyframe(map.places().find(laps.id - 8)).T_world_body);
    for (int frame = 0; frame < 6; ++frame) map.work();
  }
  CHECK(map.counts().rejected_by_gate > 3);
  CHECK(map.counts().loops == 0);
}

TEST_CASE("keyframe_map: a full one evicts, and still knows the places") {
  Laps<RelativePoseResidual<double>, 50> laps(3);
  for (int k = 0; k < 3 * per_lap - 10; ++k) {
    laps.step();
    REQUIRE(laps.map->places().size() <= 50);
  }
  CHECK(laps.map->counts().evicted > 80);
  CHECK(laps.map->places().size() == 50);
  CHECK(laps.map->counts().loops > 3);
  CHECK(laps.map_error() < 0.3);
  for (int k = 1; k < 50; ++k) CHECK(laps.map->places().keyframe(k - 1).id < laps.map->places().keyframe(k).id);
}

TEMPLATE_TEST_CASE("keyframe_map: a new world is joined to the map where a place is recognized", "",
                   RelativePoseResidual<double>, RelativeSim3Residual<double>) {
  Laps<TestType> laps(4);
  for (int k = 0; k < per_lap; ++k) laps.step();
  using Change = WorldChange<double>;
  for (std::uint32_t id = laps.id - window + 1; id <= laps.id; ++id)
    laps.map->retire(id, laps.map->places().keyframe(laps.map->places().find(id)).T_world_body);
  laps.map->change_world(Change{Change::Kind::reset, {}, {}});
  laps.T_world_body = SE3<double>(SO3<double>::exp({0.4, 1.1, -0.3}), {20, -7, 3});
  if (TestType::dim == 7) laps.scale = 0.4;
  CHECK(laps.map_error() > 5);
  for (int k = 0; k < 20; ++k) laps.step();
  CHECK(laps.map->counts().relocalizations == 1);
  CHECK(laps.map_error() < 0.15);
}

TEST_CASE("keyframe_map: what an initialization learned wrongly is discarded") {
  Laps<RelativePoseResidual<double>> laps(6);
  using Change = WorldChange<double>;
  for (int k = 0; k < 20; ++k) laps.step();
  for (std::uint32_t id = 13; id <= 20; ++id)
    laps.map->retire(id, laps.map->places().keyframe(laps.map->places().find(id)).T_world_body);
  laps.map->change_world(Change{Change::Kind::reset, {}, {}});
  for (int k = 0; k < 5; ++k) laps.step();
  REQUIRE(laps.map->places().size() == 25);
  laps.map->change_world(Change{Change::Kind::rejected, {}, {}});
  CHECK(laps.map->places().size() == 20);
  CHECK(laps.map->places().graph().nodes() == 20);
}

TEST_CASE("keyframe_map: a loop that contradicts gravity is refused") {
  Laps<RelativePoseYawResidual<double>> laps(2);
  laps.map->change_world({WorldChange<double>::Kind::transformed, {}, {}});
  for (int k = 0; k < per_lap - 12; ++k) laps.step();
  REQUIRE(laps.map->counts().loops == 0);
  // The attitude is wrong by 0.15 rad about a horizontal axis from here on; the position is right.
  laps.T_world_body = SE3<double>(SO3<double>::exp({0.15, 0, 0}) * laps.T_world_body.rotation(), laps.T_world_body.p());
  for (int k = 0; k < 30; ++k) laps.step();
  CHECK(laps.map->counts().loops == 0);
  CHECK(laps.map->counts().rejected_by_tilt + laps.map->counts().rejected_by_gate > 3);
}

TEST_CASE("keyframe_map: NaN is refused") {
  Laps<RelativePoseResidual<double>> laps(8);
  for (int k = 0; k < 5; ++k) laps.step();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(!laps.map->begin_keyframe(100, 1, SE3<double>(SO3<double>(), {nan, 0, 0}), {}, identity<double, 6>()));
  Mat<double, 6, 6> covariance = identity<double, 6>();
  covariance(2, 2) = nan;
  CHECK(!laps.map->begin_keyframe(101, 1, {}, {}, covariance));
  CHECK(laps.map->places().size() == 5);
}

TEST_CASE("keyframe_map: a unit and a direction of gravity that are found later hold for all that was learned") {
  Laps<RelativePoseResidual<double>> laps(6);
  for (int k = 0; k < 15; ++k) laps.step();
  const Sim3<double> S(0.5, SO3<double>::exp({0.1, -0.2, 0.3}), {1, 2, 3});
  const SE3<double> before = laps.map->places().keyframe(4).T_world_body;
  const float range = laps.map->places().keyframe(4).features[7].range;
  const SE3<double> T_body_cam(SO3<double>::exp({0.3, 0, -0.1}), {0.1, 0.2, -0.3});
  laps.map->change_world({WorldChange<double>::Kind::transformed, S, T_body_cam});
  const SE3<double> after = laps.map->places().keyframe(4).T_world_body;
  CHECK(norm(Vec<double, 3>((after * T_body_cam).p() - S * before.p())) < 1e-12);
  CHECK(laps.map->places().keyframe(4).features[7].range == Approx(0.5f * range));
  CHECK(norm(Vec<double, 3>(laps.map->places().graph().pose(4).p() - after.p())) < 1e-12);
}
