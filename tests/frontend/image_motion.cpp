#include "plumbline/frontend/image_motion.hpp"

#include <type_traits>

#include "catch.hpp"
#include "frontend/direct_life.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("image_motion: a prediction that is off is moved to where the images fit", "",
                   (Features<Points<150>>), (Features<Lines<60>>), (Features<Points<150>, Lines<60>>)) {
  test::DirectLife<test::DirectRgbd<double>, TestType> life;
  life.begin();
  for (int i = 1; i < 4; ++i) {
    const auto view = life.view(i);
    Vec<double, 6> off;
    off << 0.01, -0.008, 0.006, 0.02, -0.01, 0.015;
    SE3<double> T = plus(life.T(i), off);
    life.ends->align(view, life.window, *life.landmarks, {}, T);
    const Vec<double, 6> error = minus(T, life.T(i));
    const auto& found = life.ends->image_motion().latest();
    CAPTURE(i, found.patches, found.sigma_intensity);
    REQUIRE(found.valid);
    CHECK(error.head<3>().norm() < 0.25 * off.head<3>().norm());
    CHECK(error.tail<3>().norm() < 0.4 * off.tail<3>().norm());
    life.ends->follow(view, life.window, *life.landmarks, T);
    life.ends->refine(view, life.window, *life.landmarks, life.T(i));
    life.images->keep(view, life.T(i));
  }
}

TEST_CASE("image_motion: without landmarks the prediction stays") {
  test::DirectLife<test::DirectRgbd<float>, Features<Points<150>>> life;
  const auto first = life.view(0);
  life.images->keep(first, life.T(0));
  const auto view = life.view(1);
  SE3<float> T = life.T(1);
  life.ends->align(view, life.window, *life.landmarks, {}, T);
  CHECK_FALSE(life.ends->image_motion().latest().valid);
  CHECK(minus(T, life.T(1)).norm() == 0);
}

TEST_CASE("image_motion: a policy that follows each landmark by itself has no such stage") {
  using Life = test::DirectLife<test::DirectRgbd<float>, Features<Points<150>>, Flow>;
  STATIC_REQUIRE(std::is_empty_v<typename Life::Ends::ImageMotion>);
  Life life;
  life.begin();
  const auto view = life.view(1);
  SE3<float> T = life.T(0);
  life.ends->align(view, life.window, *life.landmarks, {}, T);
  CHECK(minus(T, life.T(0)).norm() == 0);
}
