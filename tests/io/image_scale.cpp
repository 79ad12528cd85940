#include "plumbline/io/image_scale.hpp"

#include <cmath>

#include "catch.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/io/make_camera.hpp"

using namespace plumbline;
using io::CameraCalibration;

TEST_CASE("image_scale: the scaled camera sees a point where the scaled image shows it") {
  const CameraCalibration cameras[] = {
      {"pinhole", "radtan", {458, 457, 367, 248}, {-0.28, 0.07, 2e-4, 1e-5}, 752, 480, 0, {}},
      {"pinhole", "equidistant", {380, 382, 375, 239}, {0.01, 0.02, -0.03, 0.01}, 752, 480, 0, {}},
      {"double_sphere", "none", {300, 301, 376, 241, -0.2, 0.6}, {}, 753, 481, 0, {}},
      {"eucm", "none", {300, 301, 376, 241, 0.6, 1.1}, {}, 752, 480, 0, {}},
      {"omni", "none", {500, 501, 376, 241, 0.9}, {}, 752, 480, 0, {}}};
  for (const CameraCalibration& camera : cameras) {
    for (const double scale : {0.5, 1.0 / 3, 0.37}) {
      CAPTURE(camera.model, scale);
      CameraCalibration small = camera;
      io::scale_camera(scale, small);
      CHECK(small.width == std::lround(scale * camera.width));
      const double by_u = double(small.width) / camera.width, by_v = double(small.height) / camera.height;
      const auto before = io::make_camera<double>(camera), after = io::make_camera<double>(small);
      for (const Vec<double, 3>& p :
           {Vec<double, 3>(0, 0, 1), Vec<double, 3>(0.5, -0.3, 1), Vec<double, 3>(-0.4, 0.4, 2)}) {
        const Vec<double, 2> uv = before.project(p).uv, uv_small = after.project(p).uv;
        CHECK(uv_small.x() + 0.5 == Approx((uv.x() + 0.5) * by_u).epsilon(1e-12));
        CHECK(uv_small.y() + 0.5 == Approx((uv.y() + 0.5) * by_v).epsilon(1e-12));
      }
    }
  }
}

TEST_CASE("image_scale: the largest 1/n that fits") {
  CameraCalibration camera;
  camera.width = 1920;
  camera.height = 1200;
  CHECK(io::fitting_scale(camera, 0) == 1);
  CHECK(io::fitting_scale(camera, 1920 * 1200) == 1);
  camera.height = 1201;
  CHECK(io::fitting_scale(camera, 1920 * 1200) == 0.5);
  camera.width = 8000;
  camera.height = 6000;
  CHECK(io::fitting_scale(camera, 1920 * 1200) == 0.2);  // 6.25 in area are 5 x 5
}

TEST_CASE("image_scale: a gray value is the mean of its pixels, a depth one that was measured") {
  cv::Mat gray(4, 6, CV_8U, cv::Scalar(10)), depth(4, 6, CV_16U, cv::Scalar(1000));
  gray.colRange(3, 6) = 50;
  depth.colRange(3, 6) = 5000;
  const cv::Mat half = io::scaled_gray(gray, 0.5), depths = io::scaled_depth(depth, 0.5);
  REQUIRE((half.cols == 3 && half.rows == 2 && depths.cols == 3 && depths.rows == 2));
  CHECK(half.at<unsigned char>(0, 0) == 10);
  CHECK(half.at<unsigned char>(0, 1) == 30);
  CHECK(half.at<unsigned char>(1, 2) == 50);
  for (int u = 0; u < 3; ++u) {
    const int value = depths.at<unsigned short>(1, u);
    CHECK((value == 1000 || value == 5000));
  }
  CHECK(depths.at<unsigned short>(0, 0) == 1000);
  CHECK(depths.at<unsigned short>(0, 2) == 5000);
}
