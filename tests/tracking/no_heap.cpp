// Nothing in image/ and tracking/ allocates: operator new and Eigen's own allocation are watched over one whole frame.
#include "allocation_counter.hpp"

#include <memory>

#include "catch.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/tracking/corner_detector.hpp"
#include "plumbline/tracking/feature_alignment.hpp"
#include "plumbline/tracking/optical_flow.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;

TEST_CASE("no heap: build, detect, capture, track and align") {
  using Pyr = Pyramid<4, 640 * 480>;
  const cv::Mat image = testing::textured_image();
  testing::AffineMotion motion;
  motion.t = testing::Vec2f(2.0f, 1.0f);
  const cv::Mat moved = testing::warped(image, motion);
  const auto previous = std::make_unique<Pyr>(), current = std::make_unique<Pyr>();
  const auto patches = std::make_unique<std::array<ReferencePatch, 150>>();
  FixedVector<Corner, 150> corners;

  bool built = false;
  int tracked = 0, aligned = 0;
  const long allocations = test::allocations_of([&] {
    built = previous->build(opencv::view<std::uint8_t>(image));
    built = current->build(opencv::view<std::uint8_t>(moved)) && built;
    detect_corners(previous->level(0), nullptr, 0, CornerOptions{}, corners);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const testing::Vec2f uv = corners[i].uv;
      const FlowResult flow = track_point_checked(*previous, *current, uv, uv, OpticalFlowOptions{});
      tracked += flow.valid;
      (*patches)[i].capture(*previous, uv);
      const Mat<float, 2, 2> A = Mat<float, 2, 2>::Identity();
      aligned += align_patch((*patches)[i], A, *current, uv, AlignmentOptions{}).valid;
      align_edge((*patches)[i], A, *current, uv, edge_normal(A, testing::Vec2f::UnitX()), AlignmentOptions{});
    }
  });
  REQUIRE(allocations == 0);
  REQUIRE(test::allocations_of([] { REQUIRE(std::make_unique<int>(3)); }) > 0);  // the watch sees what it should
  REQUIRE(built);
  REQUIRE(tracked > 100);
  REQUIRE(aligned > 100);
}
