#include "plumbline/frontend/direct_points.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "catch.hpp"
#include "frontend/direct_life.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("direct_points: located points are found where the aligned pose sees them, and stay there", "",
                   float, double) {
  test::DirectLife<test::DirectRgbd<TestType>, Features<Points<200>>> life;
  life.begin();
  const auto& store = life.landmarks->template get<0>();
  const int first = store.tracked_count();
  REQUIRE(first > 50);
  for (int i = 1; i < 8; ++i) {
    const auto view = life.view(i);
    SE3<TestType> T = life.T(i - 1);  // no prediction at all
    life.ends->align(view, life.window, *life.landmarks, {}, T);
    life.ends->follow(view, life.window, *life.landmarks, T);
    const int followed = store.tracked_count();
    life.ends->refine(view, life.window, *life.landmarks, life.T(i));
    life.images->keep(view, life.T(i));
    CAPTURE(i, first, followed, life.error_px(store, i));
    CHECK(life.error_px(store, i) < 0.3f);
    CHECK(store.tracked_count() >= followed);
    CHECK(store.tracked_count() > first / 2);
  }
}

TEST_CASE("direct_points: a landmark that was lost is found again where the pose puts it") {
  test::DirectLife<test::DirectRgbd<float>, Features<Points<200>>> life;
  life.begin();
  auto& store = life.landmarks->get<0>();
  const int first = store.tracked_count();
  for (auto& landmark : store.landmarks()) landmark.current.valid = false;
  const auto view = life.view(1);
  life.ends->follow(view, life.window, *life.landmarks, life.T(1));
  REQUIRE(store.tracked_count() == 0);
  life.ends->refine(view, life.window, *life.landmarks, life.T(1));
  CHECK(store.tracked_count() > first / 2);
  CHECK(life.error_px(store, 1) < 0.3f);
}

TEST_CASE("direct_points: a camera without depth filters the depth of new points until it is known") {
  using Life = test::DirectLife<test::DirectMono<double>, Features<Points<200>>>;
  Life life;
  life.begin();
  auto& store = life.landmarks->get<0>();
  REQUIRE(store.tracked_count() == 0);
  // A third of them is known, as a start would have it: the others are then filtered.
  std::vector<std::uint32_t> known;
  const auto truth = [&](const auto& landmark) {
    const auto& depth = test::direct_room().frames[0].depth;
    const int x = int(std::lround(landmark.observations[0].pixel.x())),
              y = int(std::lround(landmark.observations[0].pixel.y()));
    const double z = 1e-3 * depth.view()(x, y);
    return z > 0 ? landmark.geometry.bearing.z() / z : 0.0;
  };
  for (std::size_t k = 0; k < store.landmarks().size(); k += 3) {
    auto& landmark = store.landmarks()[k];
    if (!(truth(landmark) > 0)) continue;
    landmark.located = true;
    landmark.geometry.inverse_range = truth(landmark);
    landmark.geometry.sigma_inverse_range = 0.02 * truth(landmark);
    landmark.id += 200 + 1;  // the place among the filters that the next one has: located ones need none
    known.push_back(landmark.id);
  }
  for (int i = 1; i < 10; ++i) {
    const auto view = life.view(i);
    SE3<double> T = life.T(i);
    life.ends->follow(view, life.window, *life.landmarks, T);
    life.ends->refine(view, life.window, *life.landmarks, T);
    life.ends->locate(view, life.window, *life.landmarks, T);
    life.images->keep(view, T);
  }
  int filtered = 0;
  std::vector<double> errors;
  for (const auto& landmark : store.landmarks()) {
    if (!landmark.located || std::count(known.begin(), known.end(), landmark.id) > 0) continue;
    ++filtered;
    const double expected = truth(landmark);
    if (!(expected > 0)) continue;
    errors.push_back(std::abs(landmark.geometry.inverse_range / expected - 1));
    CHECK(landmark.geometry.sigma_inverse_range < 0.34 * landmark.geometry.inverse_range);
  }
  REQUIRE(filtered > 15);
  std::sort(errors.begin(), errors.end());
  CAPTURE(filtered, errors.size());
  CHECK(errors[errors.size() / 2] < 0.1);
}

TEST_CASE("direct_points: a new point that the frame has lost is found along its ray") {
  using Life = test::DirectLife<test::DirectMono<double>, Features<Points<200>>>;
  Life life;
  life.begin();
  auto& store = life.landmarks->get<0>();
  const auto& depth = test::direct_room().frames[0].depth;
  const auto inverse_range = [&](const auto& landmark) {
    const Vec<float, 2>& uv = landmark.observations[0].pixel;
    const double z = 1e-3 * depth.view()(int(std::lround(uv.x())), int(std::lround(uv.y())));
    return z > 0 ? landmark.geometry.bearing.z() / z : 0.0;
  };
  for (std::size_t k = 0; k < store.landmarks().size(); k += 3) {
    auto& landmark = store.landmarks()[k];
    landmark.geometry.inverse_range = inverse_range(landmark);
    landmark.located = landmark.geometry.inverse_range > 0;
    landmark.geometry.sigma_inverse_range = 0.02 * landmark.geometry.inverse_range;
  }
  const auto step = [&](int i, bool lose) {
    const auto view = life.view(i);
    life.ends->follow(view, life.window, *life.landmarks, life.T(i));
    int lost = 0;
    for (auto& landmark : store.landmarks()) {
      if (!lose || landmark.located || !landmark.current.valid) continue;
      landmark.current.valid = false;
      ++lost;
    }
    life.ends->refine(view, life.window, *life.landmarks, life.T(i));
    if (!lose) {
      life.ends->locate(view, life.window, *life.landmarks, life.T(i));
      life.images->keep(view, life.T(i));
    }
    return lost;
  };
  step(1, false);
  const int lost = step(3, true);
  int found = 0;
  std::vector<float> errors;
  for (const auto& landmark : store.landmarks()) {
    if (landmark.located || !landmark.current.valid) continue;
    ++found;
    const double lambda = inverse_range(landmark);
    if (!(lambda > 0)) continue;
    const Vec<double, 3> p_cam = life.T(3).inverse() * (life.T(0) * Vec<double, 3>(landmark.geometry.bearing / lambda));
    errors.push_back((life.rig.vision.camera.project(p_cam).uv.cast<float>() - landmark.current.uv).norm());
  }
  CAPTURE(lost, found, errors.size());
  REQUIRE(lost > 15);
  CHECK(found > lost / 2);
  std::sort(errors.begin(), errors.end());
  CHECK(errors[errors.size() / 2] < 0.5f);
}
