#include "plumbline/tracking/line_profile.hpp"

#include "catch.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "tracking/drawn_edges.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;
using plumbline::testing::Vec2f;

TEST_CASE("line_profile: dark to bright across an edge, alike under gain and bias, unlike elsewhere") {
  cv::Mat drawn(240, 320, CV_32F, cv::Scalar(60)), image, brighter;
  const auto shape = testing::Quadrilateral::rectangle(Vec2f(160, 120), 150, 70, 0.3f);
  testing::draw(drawn, shape, 80);
  drawn.convertTo(image, CV_8U);
  drawn.convertTo(brighter, CV_8U, 1.3, 20);
  const LineSegment edge = shape.edge(1);
  const LineProfile profile = profile_of(opencv::view<std::uint8_t>(image), edge);
  REQUIRE(profile.mean[0] == Approx(60).margin(1));
  REQUIRE(profile.mean[2 * LineProfile::radius] == Approx(140).margin(1));
  REQUIRE(profile.mean[LineProfile::radius] == Approx(100).margin(8));
  const auto similarity = [&](const cv::Mat& in, const LineSegment& s) {
    return profile.similarity(profile_of(opencv::view<std::uint8_t>(in), s));
  };
  REQUIRE(similarity(brighter, edge) > 0.999f);
  REQUIRE(similarity(image, shape.edge(3)) > 0.98f);  // another edge that looks the same
  REQUIRE(similarity(image, {edge.end, edge.start, 0}) < -0.98f);
  const Vec2f beside = 3 * edge.normal();
  REQUIRE(similarity(image, {edge.start + beside, edge.end + beside, 0}) < 0.8f);
  REQUIRE(similarity(image, {Vec2f(20, 20), Vec2f(50, 20), 0}) == 0);  // flat
  REQUIRE(similarity(image, {Vec2f(-50, 20), Vec2f(-5, 20), 0}) == 0);
}
