#include "plumbline/frontend/direct_lines.hpp"

#include <cmath>

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
