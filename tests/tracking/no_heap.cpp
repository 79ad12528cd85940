// Nothing in image/ and tracking/ allocates: operator new and Eigen's own allocation are watched over one whole frame.
#define EIGEN_RUNTIME_NO_MALLOC
#include <cstdlib>
#include <memory>
#include <new>

#include "catch.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/tracking/corner_detector.hpp"
#include "plumbline/tracking/feature_alignment.hpp"
#include "plumbline/tracking/optical_flow.hpp"
#include "tracking/warped_images.hpp"

namespace {
std::size_t allocations = 0;
}

void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

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

  const std::size_t before = allocations;
  REQUIRE(before > 0);  // the counter works
  Eigen::internal::set_is_malloc_allowed(false);
  bool built = previous->build(opencv::view<std::uint8_t>(image));
  built = current->build(opencv::view<std::uint8_t>(moved)) && built;
  detect_corners(previous->level(0), nullptr, 0, CornerOptions{}, corners);
  int tracked = 0, aligned = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const testing::Vec2f uv = corners[i].uv;
    const FlowResult flow = track_point_checked(*previous, *current, uv, uv, OpticalFlowOptions{});
    tracked += flow.valid;
    (*patches)[i].capture(*previous, uv);
    const Mat<float, 2, 2> A = Mat<float, 2, 2>::Identity();
    aligned += align_patch((*patches)[i], A, *current, uv, AlignmentOptions{}).valid;
    align_edge((*patches)[i], A, *current, uv, edge_normal(A, testing::Vec2f::UnitX()), AlignmentOptions{});
  }
  Eigen::internal::set_is_malloc_allowed(true);
  const std::size_t after = allocations;
  REQUIRE(after == before);
  REQUIRE(built);
  REQUIRE(tracked > 100);
  REQUIRE(aligned > 100);
}
