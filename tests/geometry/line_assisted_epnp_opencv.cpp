// Without rows of lines it is EPnP: against OpenCV's.
#include <vector>

#include <opencv2/calib3d.hpp>

#include "catch.hpp"
#include "line_assisted_epnp.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

TEST_CASE("line_assisted_epnp: of points alone it is as good as OpenCV's EPnP") {
  constexpr double noise = 2e-3;
  constexpr int trials = 200;
  Random random(1);
  testing::Gaussian gaussian(2);
  const auto symmetric = [&] { return 2 * random.uniform() - 1; };
  double ours = 0, theirs = 0, apart = 0;
  for (int trial = 0; trial < trials; ++trial) {
    Vec<double, 6> xi;
    for (int i = 0; i < 6; ++i) xi[i] = symmetric();
    const SE3<double> T = SE3<double>::exp(xi);
    std::vector<PoseCorrespondence<double>> points;
    std::vector<cv::Point3d> object;
    std::vector<cv::Point2d> image;
    for (int i = 0; i < 20; ++i) {
      const double z = 1 + 6 * random.uniform();
      const Vec<double, 3> p_cam(0.8 * z * symmetric(), 0.6 * z * symmetric(), z), p = T.inverse() * p_cam;
      const Vec<double, 2> uv(p_cam.x() / z + noise * gaussian(), p_cam.y() / z + noise * gaussian());
      points.push_back({Vec<double, 3>(uv.x(), uv.y(), 1).normalized(), p, noise});
      object.emplace_back(p.x(), p.y(), p.z());
      image.emplace_back(uv.x(), uv.y());
    }
    const auto pose = test::line_assisted_epnp<double>(points, {});
    REQUIRE(pose.valid);
    cv::Mat rotation, translation;
    REQUIRE(
        cv::solvePnP(object, image, cv::Mat::eye(3, 3, CV_64F), {}, rotation, translation, false, cv::SOLVEPNP_EPNP));
    const auto vector = [](const cv::Mat& m) -> Vec<double, 3> {
      return {m.at<double>(0), m.at<double>(1), m.at<double>(2)};
    };
    const SE3<double> T_opencv(SO3<double>::exp(vector(rotation)), vector(translation));
    ours += minus(pose.T_cam_world, T).squaredNorm() / trials;
    theirs += minus(T_opencv, T).squaredNorm() / trials;
    apart += minus(pose.T_cam_world, T_opencv).squaredNorm() / trials;
  }
  CAPTURE(ours, theirs, apart);
  CHECK(ours < 1.1 * theirs);
  CHECK(apart < theirs);
}
