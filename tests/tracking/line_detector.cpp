#include "plumbline/tracking/line_detector.hpp"

#include <memory>

#include "catch.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "tracking/drawn_edges.hpp"

using namespace plumbline;

namespace {

/// A user's own: the horizontal ones alone.
struct HorizontalDetector {
  LineSegmentDetector<> all;

  template <std::size_t MaxPixels, std::size_t N>
  void detect(const ImageView<const std::uint8_t>& image, EdgeMap<MaxPixels>& edges, const LineDetectorOptions& options,
              FixedVector<LineSegment, N>& out) {
    all.detect(image, edges, options, out);
    for (std::size_t i = out.size(); i-- > 0;) {
      if (!(std::abs(out[i].direction().y()) < 0.1f)) out.swap_remove(i);
    }
  }
};
struct WithoutImage {
  void detect(auto& edges, const LineDetectorOptions& options, auto& out) {
    LineSegmentDetector<>().detect(edges, options, out);
  }
};
struct WithoutDefault : HorizontalDetector {
  explicit WithoutDefault(int) {}
};

static_assert(LineDetector<HorizontalDetector>);
static_assert(!LineDetector<WithoutImage>);
static_assert(!LineDetector<WithoutDefault>);

template <LineDetector Detector>
FixedVector<LineSegment, 50> detect(const cv::Mat& image) {
  const auto edges = std::make_unique<EdgeMap<320 * 240>>();
  REQUIRE(edges->compute(opencv::view<std::uint8_t>(image), LineDetectorOptions{}.min_gradient));
  FixedVector<LineSegment, 50> out;
  std::make_unique<Detector>()->detect(opencv::view<std::uint8_t>(image), *edges, LineDetectorOptions{}, out);
  return out;
}

}  // namespace

TEST_CASE("line_detector: the default and one that a user wrote") {
  cv::Mat drawn(240, 320, CV_32F, cv::Scalar(90)), image;
  testing::draw(drawn, testing::Quadrilateral::rectangle({160, 120}, 120, 80, 0.02f), 70);
  drawn.convertTo(image, CV_8U);
  REQUIRE(detect<LineSegmentDetector<>>(image).size() == 4);
  const FixedVector<LineSegment, 50> horizontal = detect<HorizontalDetector>(image);
  REQUIRE(horizontal.size() == 2);
  for (const LineSegment& s : horizontal) REQUIRE(s.length() == Approx(120).margin(3));
}
