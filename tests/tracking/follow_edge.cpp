#include "plumbline/tracking/follow_edge.hpp"

#include <memory>

#include "catch.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/tracking/edge_map.hpp"
#include "tracking/drawn_edges.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;
using plumbline::testing::Vec2f;

namespace {

using Edges = EdgeMap<320 * 240>;

struct Scene {
  testing::Quadrilateral shape = testing::Quadrilateral::rectangle(Vec2f(160, 120), 150, 70, 0.3f);
  std::unique_ptr<Edges> edges = std::make_unique<Edges>();

  Scene() {
    cv::Mat drawn(240, 320, CV_32F, cv::Scalar(90)), image;
    testing::draw(drawn, shape, 60);
    drawn.convertTo(image, CV_8U);
    REQUIRE(edges->compute(opencv::view<std::uint8_t>(testing::with_noise(image, 2, 1)), 1.6f));
  }
};

}  // namespace

TEST_CASE("follow_edge: from a short piece with a wrong angle to both ends") {
  const Scene scene;
  const LineSegment edge = scene.shape.edge(0);
  for (const float wrong : {-0.05f, 0.0f, 0.05f}) {  // 3 degrees: 4 px at the ends
    const Vec2f origin = edge.center(), d = (edge.direction() + wrong * edge.normal()).normalized();
    FittedLine line{Vec2f::Zero(), d, 0};
    LineMoments<float> moments;
    for (int k = -8; k <= 8; ++k) moments.add(static_cast<float>(k) * d.x(), static_cast<float>(k) * d.y());
    Vec2f start = -8 * d, end = 8 * d;
    const FollowOptions options{1, 1.2f, 4, 200};
    follow_edge(*scene.edges, origin, options, -1, line, moments, start);
    follow_edge(*scene.edges, origin, options, 1, line, moments, end);
    REQUIRE((start + origin - edge.start).norm() < 4);
    REQUIRE((end + origin - edge.end).norm() < 4);
    REQUIRE(std::abs(line.direction.dot(edge.normal())) < 0.01f);
  }
}

TEST_CASE("follow_edge: no farther than asked, and nowhere without an edge or against the polarity") {
  const Scene scene;
  const LineSegment edge = scene.shape.edge(2);
  const auto followed = [&](const Vec2f& origin, const Vec2f& d, int max_steps) {
    FittedLine line{Vec2f::Zero(), d, 0};
    LineMoments<float> moments;
    for (int k = -8; k <= 8; ++k) moments.add(static_cast<float>(k) * d.x(), static_cast<float>(k) * d.y());
    Vec2f tip = Vec2f::Zero();
    follow_edge(*scene.edges, origin, FollowOptions{1, 1.2f, 4, max_steps}, 1, line, moments, tip);
    return tip.norm();
  };
  REQUIRE(followed(edge.center(), edge.direction(), 20) == Approx(20).margin(0.5));
  REQUIRE(followed(edge.center(), -edge.direction(), 20) == 0);
  REQUIRE(followed(edge.center() + 20 * edge.normal(), edge.direction(), 20) == 0);
  REQUIRE(followed(Vec2f(318, 120), Vec2f::UnitX(), 50) == 0);  // into the border of the image
}
