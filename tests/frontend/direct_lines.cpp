#include "plumbline/frontend/direct_lines.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "catch.hpp"
#include "frontend/direct_life.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("direct_lines: patches lie on the lines, in the image and in space", "", float, double) {
  using S = TestType;
  using Life = test::DirectLife<test::DirectRgbd<S>, Features<Lines<60>>>;
  using Store = std::remove_cvref_t<decltype(std::declval<Life&>().landmarks->template get<0>())>;
  Life life;
  life.begin();
  const auto& store = life.landmarks->template get<0>();
  const int lines = store.tracked_count();
  REQUIRE(lines > 5);
  const auto view = life.view(1);
  const DirectLines<Store> front_end({});
  int samples = 0;
  float weight = 0;
  front_end.for_each_alignment_sample(view, life.window, store, life.T(1), [&](const AlignmentSample<S>& sample) {
    ++samples;
    weight += sample.weight;
    const auto uv = life.rig.vision.camera.project(sample.p_body).uv;  // the body is the camera
    CHECK((uv.template cast<float>() - sample.pixel).norm() < 0.05f);
    float nearest = 1e9f;
    double from_line = 1e9;
    for (const auto& landmark : store.landmarks()) {
      if (!landmark.located) continue;
      nearest = std::min(nearest, std::abs(landmark.current.segment.distance(sample.pixel)));
      const auto line = landmark.geometry.line.template cast<double>();
      const Vec<double, 3> p = sample.p_body.template cast<double>();
      from_line = std::min(from_line, (p - line.closest_point()).cross(line.direction()).norm() / p.norm());
    }
    CHECK(nearest < 0.05f);
    CHECK(from_line < 0.03);
  });
  CHECK(samples >= 2 * lines);
  CHECK(weight <= float(DirectLineOptions{}.max_weight) * float(lines) + 1e-3f);
}

TEST_CASE("direct_lines: lines are followed from the aligned pose") {
  test::DirectLife<test::DirectRgbd<double>, Features<Lines<60>>> life;
  life.begin();
  const auto& store = life.landmarks->get<0>();
  const int first = store.tracked_count();
  for (int i = 1; i < 6; ++i) {
    const auto view = life.view(i);
    SE3<double> T = life.T(i - 1);
    life.ends->align(view, life.window, *life.landmarks, {}, T);
    life.ends->follow(view, life.window, *life.landmarks, T);
    life.ends->refine(view, life.window, *life.landmarks, life.T(i));
    life.images->keep(view, life.T(i));
    CHECK(store.tracked_count() > first / 2);
  }
}

TEST_CASE("direct_lines: a camera without depth filters the depth of new lines until it is known") {
  using Set = Features<Lines<60>>;
  test::DirectLife<test::DirectRgbd<double>, Set> truth;
  test::DirectLife<test::DirectMono<double>, Set> life;
  truth.begin();
  life.begin();
  auto& store = life.landmarks->get<0>();
  REQUIRE(store.tracked_count() == 0);
  // Both see the same segments. Every other line is known, as a start would have it: the others are then filtered.
  const auto true_line = [&](const auto& landmark) {
    for (const auto& other : truth.landmarks->get<0>().landmarks()) {
      const bool same = (other.observations[0].segment.start - landmark.observations[0].segment.start).norm() < 0.01f;
      if (same && other.located) return &other.geometry;
    }
    return static_cast<const LineGeometry<double>*>(nullptr);
  };
  std::vector<std::uint32_t> known;
  for (auto& landmark : store.landmarks()) {
    const auto* line = true_line(landmark);
    if (!line || landmark.id % 2 != 0) continue;
    landmark.geometry = *line;
    landmark.located = true;
    known.push_back(landmark.id);
  }
  REQUIRE(known.size() >= 5);
  for (int i = 1; i < 10; ++i) {
    const auto view = life.view(i);
    life.ends->follow(view, life.window, *life.landmarks, life.T(i));
    life.ends->refine(view, life.window, *life.landmarks, life.T(i));
    life.ends->locate(view, life.window, *life.landmarks, life.T(i));
    life.images->keep(view, life.T(i));
  }
  std::vector<double> errors;
  for (const auto& landmark : store.landmarks()) {
    const auto* line = true_line(landmark);
    if (!landmark.located || !line || std::count(known.begin(), known.end(), landmark.id) > 0) continue;
    const auto& seen = landmark.seen_by_anchor().pixels.measured;
    for (const auto& ray : {seen.bearing_start, seen.bearing_end}) {
      const double expected = line->line.plucker().facing_plane().dot(ray),
                   found = landmark.geometry.line.plucker().facing_plane().dot(ray);
      errors.push_back(std::abs(found / expected - 1));
    }
  }
  std::sort(errors.begin(), errors.end());
  CAPTURE(errors.size());
  REQUIRE(errors.size() >= 6);
  CHECK(errors[errors.size() / 2] < 0.1);
}
