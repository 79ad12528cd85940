#include "plumbline/tracking/orb_features.hpp"

#include <array>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/tracking/descriptor_matching.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;
using plumbline::testing::Vec2f;

namespace {

using Pyr = Pyramid<4, 640 * 480>;
using Features = FixedVector<OrbFeature, 200>;

std::unique_ptr<Pyr> built(const cv::Mat& image) {
  auto pyramid = std::make_unique<Pyr>();
  REQUIRE(pyramid->build(opencv::view<std::uint8_t>(image)));
  return pyramid;
}

}  // namespace

TEST_CASE("orb features: given points keep their index, those at the edge are left out, further corners follow") {
  const auto pyramid = built(testing::textured_image());
  const auto features = std::make_unique<Features>();
  const std::vector<Vec2f> points = {{100.3f, 90.6f}, {5, 5}, {300, 200}};
  REQUIRE(describe_points(*pyramid, points, *features) == 2);
  REQUIRE((*features)[0].point == 0);
  REQUIRE((*features)[1].point == 2);
  REQUIRE((*features)[0].uv == points[0]);
  add_corner_features(*pyramid, {}, *features);
  REQUIRE(features->full());
  std::array<int, 3> of_level{};
  for (const OrbFeature& f : *features) {
    ++of_level[static_cast<std::size_t>(f.level)];
    const OrbDescription d = OrbDescriber::describe(pyramid->level(f.level), to_level(f.uv, f.level));
    REQUIRE(d.descriptor == f.descriptor);
    if (f.point != OrbFeature::no_point || f.level != 0) continue;
    for (const int i : {0, 2}) REQUIRE((f.uv - points[static_cast<std::size_t>(i)]).norm() >= 6);
  }
  REQUIRE(of_level[0] > of_level[1]);
  REQUIRE(of_level[1] > of_level[2]);
  REQUIRE(of_level[2] > 10);
}

TEST_CASE("orb features: none beyond the capacity") {
  const auto pyramid = built(testing::textured_image());
  FixedVector<OrbFeature, 3> few;
  const std::vector<Vec2f> points(5, Vec2f(100, 100));
  REQUIRE(describe_points(*pyramid, points, few) == 3);
  add_corner_features(*pyramid, {}, few);
  REQUIRE(few.size() == 3);
  REQUIRE(few[2].point == 2);
}

TEST_CASE("orb features: coarse levels recognize a place from twice the distance") {
  const cv::Mat image = testing::textured_image();
  const testing::AffineMotion motion = testing::about_center(image, 0, 0.5f, Vec2f(0, 0));
  const auto near = built(image), far = built(testing::warped(image, motion));
  const auto right_matches = [&](int levels) {
    OrbFeatureOptions options;
    options.levels = levels;
    const auto a = std::make_unique<Features>(), b = std::make_unique<Features>();
    add_corner_features(*near, options, *a);
    add_corner_features(*far, options, *b);
    std::vector<BinaryDescriptor> first, second;
    for (const OrbFeature& f : *a) first.push_back(f.descriptor);
    for (const OrbFeature& f : *b) second.push_back(f.descriptor);
    std::vector<DescriptorMatch> matches(first.size());
    matches.resize(match_descriptors(first, second, {}, matches));
    int right = 0;
    for (const DescriptorMatch& m : matches) right += (motion((*a)[m.first].uv) - (*b)[m.second].uv).norm() < 4;
    return right;
  };
  const int fine_only = right_matches(1), with_coarse = right_matches(3);
  CAPTURE(fine_only, with_coarse);
  REQUIRE(with_coarse > 10);
  REQUIRE(with_coarse > 2 * fine_only);
}

TEST_CASE("orb features: no further corner where the mask of the pyramid excludes, on any level") {
  const auto pyramid = built(testing::textured_image());
  cv::Mat used(480, 640, CV_8U, cv::Scalar(255));
  used.rowRange(240, 480).setTo(0);
  const auto mask = std::make_unique<ImageMask<640 * 480>>();
  REQUIRE(mask->set(opencv::view<std::uint8_t>(used)));
  pyramid->set_mask(mask->view());
  const auto features = std::make_unique<Features>();
  add_corner_features(*pyramid, {}, *features);
  std::array<int, 3> of_level{};
  for (const OrbFeature& f : *features) {
    ++of_level[static_cast<std::size_t>(f.level)];
    REQUIRE(f.uv.y() < 240 - ImageMask<1>::margin_px);
  }
  for (const int count : of_level) REQUIRE(count > 5);
}
