// Binary descriptors against OpenCV's ORB: the same points in warped images with a known motion, and whole pipelines
// (corners, descriptors, matches) on pairs of recorded images, where the epipolar constraint tells which are right.
#include "plumbline/tracking/orb_descriptor.hpp"

#include "catch.hpp"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <memory>
#include <vector>

#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>

#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/tracking/descriptor_matching.hpp"
#include "plumbline/tracking/orb_features.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;
using plumbline::testing::Vec2f;

namespace {

struct Described {
  std::vector<Vec2f> uv;
  std::vector<BinaryDescriptor> descriptors;
};

Described orb(const cv::Mat& image, int levels) {
  std::vector<cv::KeyPoint> points;
  cv::Mat rows;
  cv::ORB::create(300, 1.2f, levels, 31, 0, 2, cv::ORB::HARRIS_SCORE, 31, 10)
      ->detectAndCompute(image, {}, points, rows);
  Described out;
  out.descriptors.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    out.uv.emplace_back(points[i].pt.x, points[i].pt.y);
    std::memcpy(out.descriptors[i].words.data(), rows.ptr(static_cast<int>(i)), 32);
  }
  return out;
}

/// Ours at the same points.
Described at_points_of(const Described& other, const cv::Mat& image) {
  Described out = other;
  for (std::size_t i = 0; i < out.uv.size(); ++i) {
    out.descriptors[i] = OrbDescriber::describe(opencv::view<std::uint8_t>(image), out.uv[i]).descriptor;
  }
  return out;
}

Described ours(const cv::Mat& image) {
  const auto pyramid = std::make_unique<Pyramid<4, 1300 * 480>>();
  const auto features = std::make_unique<FixedVector<OrbFeature, 300>>();
  REQUIRE(pyramid->build(opencv::view<std::uint8_t>(image)));
  add_corner_features(*pyramid, OrbFeatureOptions{}, *features);
  Described out;
  for (const OrbFeature& feature : *features) {
    out.uv.push_back(feature.uv);
    out.descriptors.push_back(feature.descriptor);
  }
  return out;
}

struct Count {
  int right = 0, all = 0;
  Count& operator+=(const Count& other) {
    right += other.right;
    all += other.all;
    return *this;
  }
  double precision() const { return double(right) / std::max(all, 1); }
};

std::vector<DescriptorMatch> matches(const Described& a, const Described& b) {
  std::vector<DescriptorMatch> out(a.uv.size());
  out.resize(match_descriptors(a.descriptors, b.descriptors, {}, out));
  return out;
}

/// Right within 3 px of the motion.
Count matched(const Described& a, const Described& b, const testing::AffineMotion& motion) {
  Count out;
  for (const DescriptorMatch& m : matches(a, b)) {
    out += {(motion(a.uv[m.first]) - b.uv[m.second]).norm() < 3, 1};
  }
  return out;
}

/// Right within 1.5 px of the epipolar lines of the fundamental matrix that most of them fit.
Count matched(const Described& a, const Described& b) {
  std::vector<cv::Point2f> p, q;
  for (const DescriptorMatch& m : matches(a, b)) {
    p.emplace_back(a.uv[m.first].x(), a.uv[m.first].y());
    q.emplace_back(b.uv[m.second].x(), b.uv[m.second].y());
  }
  Count out{0, static_cast<int>(p.size())};
  if (p.size() < 12) return out;
  cv::setRNGSeed(1);
  std::vector<unsigned char> inliers;
  cv::findFundamentalMat(p, q, cv::FM_RANSAC, 1.5, 0.999, 2000, inliers);
  for (const unsigned char is_inlier : inliers) out.right += is_inlier;
  return out;
}

}  // namespace

TEST_CASE("orb descriptor: as many correct matches as ORB at the same points of warped images") {
  const std::vector<cv::Mat> images = testing::recorded_images();
  if (images.empty()) {
    WARN("no recordings beside the project: nothing compared");
    return;
  }
  Count all_theirs, all_ours;
  for (const float degrees : {0.0f, 30.0f, 90.0f}) {
    for (const float scale : {1.0f, 1.2f, 0.8f}) {
      Count their, our;
      for (const cv::Mat& image : images) {
        const testing::AffineMotion motion = testing::about_center(image, degrees, scale, Vec2f(6.4f, -4.3f));
        const cv::Mat before = testing::with_noise(image, 2, 1);
        const cv::Mat after = testing::with_noise(testing::warped(image, motion, 1.1, 5), 2, 2);
        const Described a = orb(before, 1), b = orb(after, 1);
        their += matched(a, b, motion);
        our += matched(at_points_of(a, before), at_points_of(b, after), motion);
      }
      CAPTURE(degrees, scale, our.right, our.all, their.right, their.all);
      std::cout << degrees << " deg, scale " << scale << ": " << our.right << " correct of " << our.all << ", ORB "
                << their.right << " of " << their.all << '\n';
      REQUIRE(our.right > 0.9 * their.right);
      REQUIRE(our.precision() > their.precision() - 0.03);
      all_ours += our;
      all_theirs += their;
    }
  }
  REQUIRE(all_ours.right > 0.94 * all_theirs.right);
}

TEST_CASE("orb descriptor: pairs of recorded images, at ORB's points and with corners of its own") {
  struct Recording {
    const char* images;
    std::size_t step;  ///< [frames] between the two
  };
  Count same_theirs, same_ours, theirs, own;
  for (const Recording& recording :
       {Recording{"euroc_mh01_flight/mav0/cam0/data", 10}, Recording{"tum_fr1_rpy_first12s/rgb", 8},
        Recording{"kitti00_first20s/image_0", 2}, Recording{"rendered_office_mono/mav0/cam0/data", 10},
        Recording{"icl_office_kt0_3s/rgb", 15}, Recording{"rendered_lowtex_rgbd/rgb", 8}}) {
    const std::filesystem::path path = std::filesystem::path(PLUMBLINE_TEST_DATA) / recording.images;
    if (!std::filesystem::is_directory(path)) continue;
    std::vector<std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(path)) files.push_back(entry.path().string());
    std::sort(files.begin(), files.end());
    for (std::size_t part = 1; part <= 6; ++part) {
      const std::size_t i = part * files.size() / 8;
      const cv::Mat first = cv::imread(files[i], cv::IMREAD_GRAYSCALE);
      const cv::Mat second = cv::imread(files[std::min(i + recording.step, files.size() - 1)], cv::IMREAD_GRAYSCALE);
      const Described a = orb(first, 1), b = orb(second, 1);
      same_theirs += matched(a, b);
      same_ours += matched(at_points_of(a, first), at_points_of(b, second));
      theirs += matched(orb(first, 8), orb(second, 8));
      own += matched(ours(first), ours(second));
    }
  }
  if (theirs.all == 0) {
    WARN("no recordings beside the project: nothing compared");
    return;
  }
  std::cout << "same points: " << same_ours.right << " of " << same_ours.all << ", ORB " << same_theirs.right << " of "
            << same_theirs.all << "; own corners: " << own.right << " of " << own.all << ", ORB of 8 levels "
            << theirs.right << " of " << theirs.all << '\n';
  REQUIRE(same_ours.right > 0.94 * same_theirs.right);
  REQUIRE(same_ours.precision() > same_theirs.precision() - 0.03);
  REQUIRE(own.right > 0.9 * theirs.right);
}
