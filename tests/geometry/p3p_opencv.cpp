#include <algorithm>

#include <opencv2/calib3d.hpp>

#include "catch.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/geometry/p3p.hpp"
#include "plumbline/lie/plus.hpp"

using namespace plumbline;

TEST_CASE("p3p: finds what OpenCV's solveP3P finds") {
  Random random(11);
  const auto symmetric = [&] { return 2 * random.uniform() - 1; };
  const int trials = 5000;
  int found_by_both = 0, found_by_opencv = 0, truth_by_us = 0, truth_by_opencv = 0;
  for (int trial = 0; trial < trials; ++trial) {
    Vec<double, 6> xi;
    for (int i = 0; i < 6; ++i) xi[i] = 2 * symmetric();
    const SE3<double> T = SE3<double>::exp(xi);
    std::array<Vec<double, 3>, 3> bearings, points;
    std::vector<cv::Point3d> object;
    std::vector<cv::Point2d> image;
    for (std::size_t i = 0; i < 3; ++i) {
      const double z = 1 + 7 * random.uniform();
      const Vec<double, 3> p_cam(0.8 * z * symmetric(), 0.8 * z * symmetric(), z);
      bearings[i] = p_cam.normalized();
      points[i] = T.inverse() * p_cam;
      object.emplace_back(points[i].x(), points[i].y(), points[i].z());
      image.emplace_back(p_cam.x() / z, p_cam.y() / z);
    }
    std::vector<cv::Mat> rotation_vectors, translations;
    cv::solveP3P(object, image, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), rotation_vectors, translations,
                 cv::SOLVEPNP_AP3P);
    const FixedVector<SE3<double>, 4> ours = p3p(bearings, points);
    const auto has = [&](const SE3<double>& pose) {
      return std::any_of(ours.begin(), ours.end(), [&](const auto& T_i) { return minus(T_i, pose).norm() < 1e-5; });
    };
    truth_by_us += has(T);
    bool opencv_has_truth = false;
    for (std::size_t i = 0; i < translations.size(); ++i) {
      const cv::Mat &r = rotation_vectors[i], &t = translations[i];
      const SE3<double> theirs(SO3<double>::exp({r.at<double>(0), r.at<double>(1), r.at<double>(2)}),
                               {t.at<double>(0), t.at<double>(1), t.at<double>(2)});
      double worst = 0;  // OpenCV returns some poses that do not explain the bearings, or see the points from behind
      for (std::size_t k = 0; k < 3; ++k) {
        worst = std::max(worst, ((theirs * points[k]).normalized() - bearings[k]).norm());
      }
      opencv_has_truth = opencv_has_truth || minus(theirs, T).norm() < 1e-5;
      if (!(worst < 1e-9)) continue;
      ++found_by_opencv;
      found_by_both += has(theirs);
    }
    truth_by_opencv += opencv_has_truth;
  }
  CAPTURE(found_by_opencv, found_by_both, truth_by_us, truth_by_opencv);
  CHECK(found_by_opencv > trials);
  CHECK(found_by_both >= 0.999 * found_by_opencv);
  CHECK(truth_by_us >= truth_by_opencv);
  CHECK(truth_by_us >= 0.999 * trials);
}
