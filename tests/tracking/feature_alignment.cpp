#include "plumbline/tracking/feature_alignment.hpp"

#include <limits>
#include <memory>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/tracking/corner_detector.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;
using plumbline::testing::AffineMotion;
using plumbline::testing::Vec2f;

namespace {

using Pyr = Pyramid<4, 1300 * 480>;
using Mat2f = Mat<float, 2, 2>;

struct Aligned {
  std::vector<double> errors;
  std::size_t tried = 0;
};

/// Aligns the corners of the image in the image after the motion, from guesses wrong by `guess_px` in all directions.
Aligned align_corners(const cv::Mat& image, const AffineMotion& motion, double gain, double bias, double noise,
                      float guess_px, const AlignmentOptions& options = {}) {
  const auto reference = std::make_unique<Pyr>(), current = std::make_unique<Pyr>();
  REQUIRE(reference->build(opencv::view<std::uint8_t>(testing::with_noise(image, noise, 1))));
  const cv::Mat moved = testing::warped(image, motion, gain, bias);
  REQUIRE(current->build(opencv::view<std::uint8_t>(testing::with_noise(moved, noise, 2))));
  FixedVector<Corner, 150> corners;
  detect_corners(reference->level(0), nullptr, 0, CornerOptions{}, corners);
  Aligned out;
  float angle = 0;
  for (const Corner& corner : corners) {
    const Vec2f truth = motion(corner.uv);
    if (!current->level(0).contains(truth.x(), truth.y(), 24.0f)) continue;
    ++out.tried;
    ReferencePatch patch;
    REQUIRE(patch.capture(*reference, corner.uv));
    angle += 2.4f;
    const Vec2f guess = truth + guess_px * Vec2f(std::cos(angle), std::sin(angle));
    const Alignment alignment = align_patch(patch, motion.A, *current, guess, options);
    if (alignment.valid) out.errors.push_back(double((alignment.uv - truth).norm()));
  }
  return out;
}

Mat2f make(float a, float b, float c, float d) {
  Mat2f A;
  A << a, b, c, d;
  return A;
}

}  // namespace

TEST_CASE("feature alignment: sub-pixel under known affine warps with gain, bias and noise") {
  std::vector<cv::Mat> images = testing::recorded_images();
  images.push_back(testing::textured_image());
  std::vector<double> all;
  for (const cv::Mat& image : images) {
    for (const auto& [degrees, scale] : {std::pair(5.0f, 1.1f), std::pair(-30.0f, 0.9f), std::pair(90.0f, 1.0f)}) {
      const AffineMotion motion = testing::about_center(image, degrees, scale, Vec2f(3.3f, -2.2f));
      const Aligned result = align_corners(image, motion, 0.85, 12.0, 1.0, 1.5f);
      REQUIRE(result.tried > 40);
      INFO(result.errors.size() << " of " << result.tried << ", median " << testing::quantile(result.errors, 0.5));
      REQUIRE(result.errors.size() > result.tried * 85 / 100);
      REQUIRE(testing::quantile(result.errors, 0.5) < 0.1);
      REQUIRE(testing::quantile(result.errors, 0.9) < 0.4);
      all.insert(all.end(), result.errors.begin(), result.errors.end());
    }
  }
  INFO("median of all " << testing::quantile(all, 0.5));
  REQUIRE(testing::quantile(all, 0.5) < 0.05);
}

TEST_CASE("feature alignment: magnified features are searched on a coarser level") {
  const cv::Mat image = testing::textured_image();
  const AffineMotion motion = testing::about_center(image, 10.0f, 2.5f, Vec2f(1, 1));
  REQUIRE(search_level(motion.A, Pyr::levels - 1) == 1);
  const Aligned result = align_corners(image, motion, 1.0, 0.0, 1.0, 2.0f);
  REQUIRE(result.tried > 10);
  REQUIRE(result.errors.size() > result.tried * 80 / 100);
  REQUIRE(testing::quantile(result.errors, 0.5) < 0.15);  // px of level 0: half of that on the search level
}

TEST_CASE("feature alignment: a coarse start reaches farther") {
  const cv::Mat image = testing::textured_image();
  const AffineMotion motion = testing::about_center(image, 5.0f, 1.0f, Vec2f(1, 1));
  AlignmentOptions coarse;
  coarse.coarse_start = true;
  const Aligned near = align_corners(image, motion, 1.0, 0.0, 1.0, 6.0f);
  const Aligned far = align_corners(image, motion, 1.0, 0.0, 1.0, 6.0f, coarse);
  REQUIRE(near.errors.size() < near.tried / 10);  // beyond max_move_px
  REQUIRE(far.errors.size() > far.tried * 85 / 100);
  REQUIRE(testing::quantile(far.errors, 0.9) < 0.2);
}

TEST_CASE("feature alignment: information is that of level 0 and predicts the scatter") {
  // Independent noise on the current image: the covariance of uv is sigma^2 information^-1.
  const cv::Mat image = testing::textured_image();
  const auto reference = std::make_unique<Pyr>(), current = std::make_unique<Pyr>();
  REQUIRE(reference->build(opencv::view<std::uint8_t>(image)));
  FixedVector<Corner, 40> corners;
  detect_corners(reference->level(0), nullptr, 0, CornerOptions{}, corners);
  const double sigma = 4.0;
  double normalized = 0;
  int count = 0;
  for (int trial = 0; trial < 20; ++trial) {
    REQUIRE(current->build(opencv::view<std::uint8_t>(testing::with_noise(image, sigma, std::uint64_t(trial) + 10))));
    for (const Corner& corner : corners) {
      ReferencePatch patch;
      REQUIRE(patch.capture(*reference, corner.uv));
      const Alignment alignment = align_patch(patch, Mat2f::Identity(), *current, corner.uv, AlignmentOptions{});
      if (!alignment.valid) continue;
      const Vec2f error = alignment.uv - corner.uv;
      normalized += double(error.dot(alignment.information_per_intensity * error)) / (sigma * sigma);
      ++count;
    }
  }
  REQUIRE(count > 600);
  // chi^2 with two degrees of freedom has mean 2; less here, because interpolation between pixels smooths the noise.
  REQUIRE(normalized / count > 0.8);
  REQUIRE(normalized / count < 2.2);
}

TEST_CASE("feature alignment: an edge moves along its normal alone") {
  cv::Mat edge(480, 640, CV_32F);
  edge.forEach<float>([](float& value, const int* at) {  // at angle 0.5 through (320, 240)
    const double distance = (at[1] - 320) * std::cos(0.5) + (at[0] - 240) * std::sin(0.5);
    value = static_cast<float>(110 + 80 * std::tanh(distance / 1.5));
  });
  cv::Mat image;
  edge.convertTo(image, CV_8U);
  const AffineMotion motion = testing::about_center(image, 20.0f, 1.2f, Vec2f(2.4f, 1.7f));
  const auto reference = std::make_unique<Pyr>(), current = std::make_unique<Pyr>();
  REQUIRE(reference->build(opencv::view<std::uint8_t>(image)));
  const cv::Mat moved = testing::with_noise(testing::warped(image, motion, 1.0, 10.0), 1.0, 3);
  REQUIRE(current->build(opencv::view<std::uint8_t>(moved)));
  const Vec2f uv(320, 240), n_ref(std::cos(0.5f), std::sin(0.5f));
  const Vec2f n_cur = edge_normal(motion.A, n_ref), truth = motion(uv);
  ReferencePatch patch;
  REQUIRE(patch.capture(*reference, uv));
  for (const float offset : {-2.0f, -0.6f, 1.1f, 2.5f}) {
    const Vec2f guess = truth + offset * n_cur + 1.5f * Vec2f(-n_cur.y(), n_cur.x());
    const Alignment alignment = align_edge(patch, motion.A, *current, guess, n_cur, AlignmentOptions{});
    REQUIRE(alignment.valid);
    REQUIRE(std::abs(n_cur.dot(alignment.uv - truth)) < 0.05f);
    REQUIRE((alignment.uv - guess).dot(Vec2f(-n_cur.y(), n_cur.x())) == Approx(0.0f).margin(1e-3));
    const Mat2f& information = alignment.information_per_intensity;
    REQUIRE((information * Vec2f(-n_cur.y(), n_cur.x())).norm() < 1e-4f * information.norm());
    REQUIRE_FALSE(align_patch(patch, motion.A, *current, guess, AlignmentOptions{}).valid);  // slides along the edge
  }
}

TEST_CASE("feature alignment: noise is no texture") {
  Mat2f H = make(900, 200, 200, 500);
  REQUIRE((without_noise(H, 100) - make(800, 200, 200, 400)).norm() < 1e-3f);
  REQUIRE(without_noise(Mat2f(300 * Mat2f::Identity()), 100) == 200 * Mat2f::Identity());
  REQUIRE(without_noise(H, 0).isApprox(H));
  const Vec2f along(std::cos(0.3f), std::sin(0.3f)), across(-along.y(), along.x());
  H = 5000 * across * across.transpose() + 90 * along * along.transpose();
  const Mat2f edge = without_noise(H, 100);
  REQUIRE(along.dot(edge * along) == Approx(1.0f).epsilon(1e-2));
  REQUIRE(across.dot(edge * across) == Approx(4900.0f).epsilon(1e-3));

  // A straight edge in a noisy image: aligned, and its place along the edge stays unknown.
  cv::Mat image(480, 640, CV_8U);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(120 + 60 * std::tanh((x - 320.3) / 1.5));
    }
  }
  const auto reference = std::make_unique<Pyr>(), current = std::make_unique<Pyr>();
  int aligned = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    REQUIRE(reference->build(opencv::view<std::uint8_t>(testing::with_noise(image, 2.0, 2 * seed))));
    REQUIRE(current->build(opencv::view<std::uint8_t>(testing::with_noise(image, 2.0, 2 * seed + 1))));
    ReferencePatch patch;
    REQUIRE(patch.capture(*reference, Vec2f(320, 240)));
    const Alignment found = align_patch(patch, Mat2f::Identity(), *current, Vec2f(320, 240), AlignmentOptions{});
    if (!found.valid) continue;
    ++aligned;
    const float error = (found.uv - Vec2f(320, 240)).y(), information = found.information_per_intensity(1, 1);
    REQUIRE(error * error * information < 9 * 15 * 15);  // within 3 sigma of a pixel that errs by 15
    REQUIRE(15 / std::sqrt(information) > 5.0f);         // px; 2 with the noise as texture
    REQUIRE(found.information_per_intensity(0, 0) > 50 * information);
  }
  REQUIRE(aligned > 5);
}

TEST_CASE("feature alignment: an edge normal maps as a covector") {
  Random random(17);
  int large = 0;
  for (int i = 0; i < 100; ++i) {
    Mat2f A;
    for (float& a : A.reshaped()) a = float(2 * random.uniform() - 1);
    A += 1.5f * Mat2f::Identity();
    if (search_level(A, 3) < 0) continue;
    const float angle = float(6.28 * random.uniform());
    const Vec2f n_ref(std::cos(angle), std::sin(angle)), direction_ref(-n_ref.y(), n_ref.x());
    const Vec2f n_cur = edge_normal(A, n_ref);
    REQUIRE(n_cur.norm() == Approx(1.0f));
    REQUIRE(std::abs(n_cur.dot(A * direction_ref)) < 1e-5f);              // orthogonal to the mapped edge
    REQUIRE(n_cur.dot(A * n_ref) > 0.0f);                                 // and to the same side
    large += std::abs(Vec2f(A * n_ref).normalized().dot(n_cur)) < 0.95f;  // A n would have been wrong
  }
  REQUIRE(large > 10);
}

TEST_CASE("feature alignment: search level and rejection of warps") {
  const Mat2f I = Mat2f::Identity();
  REQUIRE(search_level(I, 3) == 0);
  REQUIRE(search_level(1.7f * I, 3) == 0);
  REQUIRE(search_level(1.75f * I, 3) == 1);
  REQUIRE(search_level(3.6f * I, 3) == 2);
  REQUIRE(search_level(3.6f * I, 1) == 1);
  REQUIRE(search_level(0.3f * I, 3) == 0);
  REQUIRE(search_level(0.2f * I, 3) == -1);
  REQUIRE(search_level(5.1f * I, 3) == -1);
  REQUIRE(search_level(make(1, 0, 0, -1), 3) == -1);  // a mirror
  REQUIRE(search_level(make(2.4f, 0, 0, 0.32f), 3) == 0);
  REQUIRE(search_level(make(2.4f, 0, 0, 0.29f), 3) == -1);
  REQUIRE(search_level(Mat2f::Zero(), 3) == -1);
  REQUIRE(search_level(std::numeric_limits<float>::quiet_NaN() * I, 3) == -1);
}

TEMPLATE_TEST_CASE("feature alignment: affine warp is the derivative of the plane's image motion", "", float, double) {
  using S = TestType;
  const Pinhole<S> camera_ref{S(400), S(410), S(320), S(240)}, camera_cur{S(500), S(490), S(300), S(250)};
  const SE3<S> T_cur_ref(SO3<S>::exp(Vec<S, 3>(S(0.1), S(-0.2), S(0.3))), Vec<S, 3>(S(0.3), S(-0.1), S(0.4)));
  const Vec<S, 2> uv(S(410), S(190));
  const Vec<S, 3> bearing = camera_ref.unproject(uv).bearing, normal(S(0.2), S(0.3), S(-1.5));
  const S range = S(2.5);
  const auto current_uv = [&](const Vec<S, 2>& at, bool plane) {
    const Vec<S, 3> b = camera_ref.unproject(at).bearing;
    const S r = plane ? range * normal.dot(bearing) / normal.dot(b) : range;
    return camera_cur.project(T_cur_ref * Vec<S, 3>(r * b)).uv;
  };
  for (const bool plane : {true, false}) {
    const AffineWarp warp = affine_warp(camera_ref, camera_cur, bearing, range, T_cur_ref);
    Vec2f slant;  // of (6): the derivative of 1/r
    for (int axis = 0; axis < 2; ++axis) {
      const Vec<S, 2> d = S(0.5) * Vec<S, 2>::Unit(axis);
      const auto part = [&](const Vec<S, 2>& at) { return normal.dot(camera_ref.unproject(at).bearing); };
      slant[axis] = float((part(uv + d) - part(uv - d)) / normal.dot(bearing));
    }
    const Mat2f A = plane ? warp.slanted(slant) : warp.A_cur_ref;
    for (int axis = 0; axis < 2; ++axis) {
      const Vec<S, 2> d = S(0.5) * Vec<S, 2>::Unit(axis);
      const Vec<S, 2> numeric = current_uv(uv + d, plane) - current_uv(uv - d, plane);
      REQUIRE((A.col(axis).template cast<S>() - numeric).norm() < S(1e-3) * numeric.norm());
    }
  }
  const SE3<S> behind(SO3<S>(), Vec<S, 3>(S(0), S(0), S(-5)));
  REQUIRE(search_level(affine_warp(camera_ref, camera_cur, bearing, range, behind).A_cur_ref, 3) == -1);
}

TEST_CASE("feature alignment: bad input is refused") {
  const cv::Mat image = testing::textured_image();
  const auto pyramid = std::make_unique<Pyr>();
  REQUIRE(pyramid->build(opencv::view<std::uint8_t>(image)));
  FixedVector<Corner, 1> corners;
  detect_corners(pyramid->level(0), nullptr, 0, CornerOptions{}, corners);
  const Vec2f uv = corners[0].uv;
  ReferencePatch patch;
  REQUIRE(patch.capture(*pyramid, uv));
  const Mat2f I = Mat2f::Identity();
  const AlignmentOptions options;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  REQUIRE(align_patch(patch, I, *pyramid, uv, options).valid);
  REQUIRE_FALSE(align_patch(ReferencePatch{}, I, *pyramid, uv, options).valid);
  REQUIRE_FALSE(align_patch(patch, Mat2f(nan * I), *pyramid, uv, options).valid);
  REQUIRE_FALSE(align_patch(patch, I, *pyramid, Vec2f(nan, 100), options).valid);
  REQUIRE_FALSE(align_patch(patch, I, *pyramid, Vec2f(-5, 100), options).valid);
  REQUIRE_FALSE(align_edge(patch, I, *pyramid, uv, Vec2f(nan, 0), options).valid);
  const auto empty = std::make_unique<Pyr>(), flat = std::make_unique<Pyr>();
  REQUIRE_FALSE(align_patch(patch, I, *empty, uv, options).valid);
  REQUIRE(flat->build(opencv::view<std::uint8_t>(cv::Mat(480, 640, CV_8U, cv::Scalar(128)))));
  REQUIRE_FALSE(align_patch(patch, I, *flat, uv, options).valid);
  const auto darker = std::make_unique<Pyr>();  // beyond the accepted gain
  REQUIRE(darker->build(opencv::view<std::uint8_t>(testing::warped(image, AffineMotion{}, 0.3, 0.0))));
  REQUIRE_FALSE(align_patch(patch, I, *darker, uv, options).valid);
}
