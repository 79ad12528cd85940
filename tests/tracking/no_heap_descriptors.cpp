// Nothing of the binary descriptors allocates: corners, descriptors and matches of two frames.
#include "allocation_counter.hpp"

#include <array>
#include <memory>

#include "catch.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/tracking/descriptor_matching.hpp"
#include "plumbline/tracking/orb_features.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;

TEST_CASE("no heap: corners, binary descriptors and their matches") {
  using Pyr = Pyramid<4, 640 * 480>;
  constexpr std::size_t n = 300;
  const cv::Mat image = testing::textured_image();
  testing::AffineMotion motion;
  motion.t = testing::Vec2f(5, 3);
  const cv::Mat moved = testing::warped(image, motion);
  const auto pyramid = std::make_unique<Pyr>();
  const auto a = std::make_unique<FixedVector<OrbFeature, n>>(), b = std::make_unique<FixedVector<OrbFeature, n>>();
  const auto first = std::make_unique<std::array<BinaryDescriptor, n>>();
  const auto second = std::make_unique<std::array<BinaryDescriptor, n>>();
  const auto matches = std::make_unique<std::array<DescriptorMatch, n>>();
  const std::array<testing::Vec2f, 2> tracked = {testing::Vec2f(50, 60), testing::Vec2f(200, 100)};
  std::size_t found = 0;
  const long allocations = test::allocations_of([&] {
    pyramid->build(opencv::view<std::uint8_t>(image));
    describe_points(*pyramid, tracked, *a);
    add_corner_features(*pyramid, OrbFeatureOptions{}, *a);
    pyramid->build(opencv::view<std::uint8_t>(moved));
    add_corner_features(*pyramid, OrbFeatureOptions{}, *b);
    for (std::size_t i = 0; i < a->size(); ++i) (*first)[i] = (*a)[i].descriptor;
    for (std::size_t i = 0; i < b->size(); ++i) (*second)[i] = (*b)[i].descriptor;
    found =
        match_descriptors({first->data(), a->size()}, {second->data(), b->size()}, DescriptorMatchOptions{}, *matches);
  });
  REQUIRE(allocations == 0);
  REQUIRE(found > n / 2);
}
