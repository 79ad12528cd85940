#include "plumbline/tracking/surface_slant.hpp"

#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <opencv2/core.hpp>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/tracking/corner_detector.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;
using Pyr = Pyramid<4, 1300 * 480>;
using plumbline::testing::Vec2f;

namespace {

/// A textured plane through (0, 0, 3 m), seen by a camera at the origin, which looks along z, and from elsewhere.
struct Scene {
  Pinhole<double> camera{400, 400, 320, 240};
  Vec<double, 3> normal;
  cv::Mat seen_first = plumbline::testing::textured_image();
  std::unique_ptr<Pyr> reference = std::make_unique<Pyr>();

  /// `tilt` [rad] of the normal about the image's axes, from the one that faces the camera.
  explicit Scene(const Vec<double, 2>& tilt)
      : normal(SO3<double>::exp(Vec<double, 3>(tilt.x(), tilt.y(), 0)) * Vec<double, 3>(0, 0, 1)) {
    REQUIRE(reference->build(opencv::view<std::uint8_t>(seen_first)));
  }
  double range(const Vec<double, 3>& bearing) const { return 3 * normal.z() / normal.dot(bearing); }
  /// a of (6) by differences.
  Vec2f slant_at(const Vec2f& uv) const {
    Vec2f a;
    const auto inverse_range = [&](const Vec<double, 2>& at) { return 1 / range(camera.unproject(at).bearing); };
    for (int k = 0; k < 2; ++k) {
      const Vec<double, 2> at = uv.cast<double>(), d = 1e-3 * Vec<double, 2>::Unit(k);
      a[k] = float((inverse_range(at + d) - inverse_range(at - d)) / (2e-3 * inverse_range(at)));
    }
    return a;
  }
  Vec2f uv_from(const SE3<double>& T_cur_ref, const Vec2f& uv) const {
    const Vec<double, 3> b = camera.unproject(uv.cast<double>()).bearing;
    return camera.project(T_cur_ref * Vec<double, 3>(range(b) * b)).uv.cast<float>();
  }
  std::unique_ptr<Pyr> seen_from(const SE3<double>& T_cur_ref, double noise) const {
    // What pixel of the reference a pixel of the current image shows: through the plane.
    const SE3<double> T_ref_cur = T_cur_ref.inverse();
    const Vec<double, 3> n_cur = T_cur_ref.rotation() * normal;
    const double height = 3 * normal.z() + n_cur.dot(T_cur_ref.p());
    cv::Mat map_x(480, 640, CV_32F), map_y(480, 640, CV_32F), image;
    for (int y = 0; y < map_x.rows; ++y) {
      for (int x = 0; x < map_x.cols; ++x) {
        const Vec<double, 3> b = camera.unproject(Vec<double, 2>(x, y)).bearing;
        const auto at = camera.project(T_ref_cur * Vec<double, 3>(b * (height / n_cur.dot(b))));
        map_x.at<float>(y, x) = float(at.uv.x());
        map_y.at<float>(y, x) = float(at.uv.y());
      }
    }
    cv::remap(seen_first, image, map_x, map_y, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
    auto pyramid = std::make_unique<Pyr>();
    REQUIRE(pyramid->build(opencv::view<std::uint8_t>(plumbline::testing::with_noise(image, noise, 3))));
    return pyramid;
  }
  AffineWarp warp(const SE3<double>& T_cur_ref, const Vec2f& uv) const {
    const Vec<double, 3> b = camera.unproject(uv.cast<double>()).bearing;
    return affine_warp(camera, camera, b, range(b), T_cur_ref);
  }
};

/// The camera `x` [m] aside, turned so that it looks at the same place.
SE3<double> aside(double x, double y = 0) {
  return SE3<double>(SO3<double>::exp(Vec<double, 3>(y / 3, -x / 3, 0)), Vec<double, 3>(0, 0, 0)) *
         SE3<double>(SO3<double>(), Vec<double, 3>(-x, -y, 0));
}

double median(std::vector<double> values) {
  REQUIRE(values.size() > 20);
  std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
  return values[values.size() / 2];
}

FixedVector<Corner, 150> corners_of(const Scene& scene) {
  FixedVector<Corner, 150> corners;
  detect_corners(scene.reference->level(0), nullptr, 0, CornerOptions{}, corners);
  return corners;
}

}  // namespace

TEST_CASE("surface slant: the rows are the derivative of the warped template") {
  Scene scene({0.3, -0.5});
  cv::GaussianBlur(scene.seen_first, scene.seen_first, {15, 15}, 2.0);  // as smooth as central differences need it
  REQUIRE(scene.reference->build(opencv::view<std::uint8_t>(scene.seen_first)));
  const Vec2f uv = corners_of(scene)[0].uv, slant(1e-4f, -2e-4f);
  ReferencePatch patch;
  REQUIRE(patch.capture(*scene.reference, uv));
  const AffineWarp warp = scene.warp(aside(0.4, 0.3), uv);
  constexpr int n = 10;
  const auto sampled = [&](const Vec2f& a) {
    Patch<n> T;
    REQUIRE(warp_template<n>(patch, warp.slanted(a), 0, T));
    return T;
  };
  // An image that is the template of another slant: what solves H da = h is the difference, to first order.
  for (const Vec2f& da : {Vec2f(8e-4f, 0), Vec2f(0, 8e-4f), Vec2f(-6e-4f, 6e-4f)}) {
    const Patch<n> T = sampled(slant + da);
    cv::Mat image(480, 640, CV_8U, cv::Scalar(0));
    for (int k = 0; k < n * n; ++k)
      image.at<std::uint8_t>(200 + k / n, 300 + k % n) = static_cast<std::uint8_t>(std::lround(T[k]));
    const auto current = std::make_unique<Pyr>();
    REQUIRE(current->build(opencv::view<std::uint8_t>(image)));
    const SlantEquations seen = slant_equations<n>(patch, warp, slant, *current, Vec2f(304.5f, 204.5f));
    REQUIRE(seen.valid);
    const Vec2f found = seen.H.inverse() * seen.h;
    CAPTURE(da.transpose(), found.transpose());
    CHECK((found - da).norm() < 0.15f * da.norm());
  }
}

TEST_CASE("surface slant: estimated from a few views, and patches are aligned with it") {
  for (const Vec<double, 2>& tilt : {Vec<double, 2>(0.9, 0), Vec<double, 2>(-0.4, 0.7), Vec<double, 2>(0, 0)}) {
    const Scene scene(tilt);
    const auto corners = corners_of(scene);
    std::vector<ReferencePatch> patches(corners.size());
    std::vector<SurfaceSlant> slants(corners.size());
    for (std::size_t i = 0; i < corners.size(); ++i) patches[i].capture(*scene.reference, corners[i].uv);
    std::vector<double> off_facing, off_slanted, error, wrong;
    for (const double x : {0.1, 0.25, 0.4, 0.6, 0.8}) {
      const SE3<double> T = aside(x, 0.5 * x);
      const auto current = scene.seen_from(T, 2);
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec2f truth = scene.uv_from(T, corners[i].uv);
        if (patches[i].levels() == 0 || !current->level(0).contains(truth.x(), truth.y(), 16.0f)) continue;
        const AffineWarp warp = scene.warp(T, corners[i].uv);
        const AlignmentOptions options;
        const Alignment facing = align_patch(patches[i], warp.A_cur_ref, *current, truth, options);
        const Alignment slanted = align_patch(patches[i], warp.slanted(slants[i].a()), *current, truth, options);
        if (x == 0.8 && facing.valid && slanted.valid) {
          off_facing.push_back(double((facing.uv - truth).norm()));
          off_slanted.push_back(double((slanted.uv - truth).norm()));
          error.push_back(400 * double((slants[i].a() - scene.slant_at(corners[i].uv)).norm()));
          wrong.push_back(400 * double(scene.slant_at(corners[i].uv).norm()));
        }
        if (slanted.valid)
          slants[i].learn(slant_equations(patches[i], warp, slants[i].a(), *current, slanted.uv), 400, SlantOptions{});
      }
    }
    CAPTURE(tilt.transpose(), median(off_facing), median(off_slanted), median(error), median(wrong));
    const bool faces = tilt.norm() == 0;
    CHECK(median(error) < (faces ? 0.1 : 0.25 * median(wrong)));
    if (faces)
      CHECK(median(off_slanted) < 1.3 * median(off_facing));
    else
      CHECK(median(off_slanted) < 0.6 * median(off_facing));
  }
}

TEST_CASE("surface slant: no information, no change") {
  const Scene scene({0.8, 0});
  const Vec2f uv = corners_of(scene)[0].uv;
  ReferencePatch patch;
  REQUIRE(patch.capture(*scene.reference, uv));
  const SE3<double> here;
  const SlantEquations same = slant_equations(patch, scene.warp(here, uv), zeros<float, 2>(), *scene.reference, uv);
  SurfaceSlant slant;
  slant.learn(same, 400, {});
  CHECK(slant.a().norm() * 400 < 1e-3f);  // without parallax

  const SE3<double> T = aside(0.4);
  const AffineWarp warp = scene.warp(T, uv);
  const auto current = scene.seen_from(T, 0);
  const Vec2f truth = scene.uv_from(T, uv);
  REQUIRE(slant_equations(patch, warp, slant.a(), *current, truth).valid);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  CHECK_FALSE(slant_equations(ReferencePatch{}, warp, slant.a(), *current, truth).valid);
  CHECK_FALSE(slant_equations(patch, warp, Vec2f(nan, 0), *current, truth).valid);
  CHECK_FALSE(slant_equations(patch, warp, slant.a(), *current, Vec2f(nan, 100)).valid);
  CHECK_FALSE(slant_equations(patch, warp, slant.a(), *current, Vec2f(2, 100)).valid);
  CHECK_FALSE(
      slant_equations(patch, AffineWarp{zeros<float, 2, 2>(), zeros<float, 2>()}, slant.a(), *current, truth).valid);
  const auto flat = std::make_unique<Pyr>(), empty = std::make_unique<Pyr>();
  CHECK_FALSE(slant_equations(patch, warp, slant.a(), *empty, truth).valid);
  REQUIRE(flat->build(opencv::view<std::uint8_t>(cv::Mat(480, 640, CV_8U, cv::Scalar(128)))));
  slant = {};
  slant.learn(slant_equations(patch, warp, slant.a(), *flat, truth), 400, {});
  CHECK(slant.a().norm() == 0);

  SlantEquations wild;
  wild.valid = true;
  wild.H = 1e12f * Mat<float, 2, 2>::Identity();
  wild.h = 1e12f * Vec2f(1, 1);  // steeper than surfaces are
  slant.learn(wild, 400, {});
  CHECK(slant.a().norm() * 400 == Approx(SlantOptions{}.max_tangent));
}
