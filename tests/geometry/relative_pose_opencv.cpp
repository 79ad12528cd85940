#include "plumbline/geometry/relative_pose.hpp"

#include <algorithm>
#include <vector>

#include <opencv2/calib3d.hpp>

#include "catch.hpp"
#include "geometry/two_view_scene.hpp"

using namespace plumbline;
using testing::TwoViewKind;
using testing::TwoViewScene;

TEST_CASE("relative_pose: no worse than OpenCV's findEssentialMat and recoverPose") {
  const TwoViewKind kind = GENERATE(TwoViewKind::general, TwoViewKind::forward);
  const double wrong = GENERATE(0.0, 0.3);
  std::vector<double> ours_rotation, ours_direction, theirs_rotation, theirs_direction;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const TwoViewScene scene(kind, seed, TwoViewScene::pixel, wrong);
    const auto found = RelativePoseSolver<double, 200>().solve(scene.pairs, SO3<double>());
    ours_rotation.push_back(scene.rotation_error(found.two_view.T_2_1));
    ours_direction.push_back(scene.direction_error(found.two_view.T_2_1));

    std::vector<cv::Point2d> first, second;
    for (const BearingPair<double>& pair : scene.pairs) {
      first.emplace_back(pair.f1.x() / pair.f1.z(), pair.f1.y() / pair.f1.z());
      second.emplace_back(pair.f2.x() / pair.f2.z(), pair.f2.y() / pair.f2.z());
    }
    cv::setRNGSeed(int(seed));
    cv::Mat mask, R, t;
    const cv::Mat E = cv::findEssentialMat(first, second, cv::Mat::eye(3, 3, CV_64F), cv::RANSAC, 0.999,
                                           2 * TwoViewScene::pixel, mask);
    cv::recoverPose(E, first, second, cv::Mat::eye(3, 3, CV_64F), R, t, mask);
    Mat<double, 3, 3> R_2_1;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) R_2_1(i, j) = R.at<double>(i, j);
    }
    const SE3<double> theirs(SO3<double>::from_matrix(R_2_1), {t.at<double>(0), t.at<double>(1), t.at<double>(2)});
    theirs_rotation.push_back(scene.rotation_error(theirs));
    theirs_direction.push_back(scene.direction_error(theirs));
  }
  const auto part = [](std::vector<double>& v, double p) {
    std::sort(v.begin(), v.end());
    return v[std::size_t(p * double(v.size()))];
  };
  for (const double p : {0.5, 0.9}) {
    const double r = part(ours_rotation, p), d = part(ours_direction, p);
    const double r_cv = part(theirs_rotation, p), d_cv = part(theirs_direction, p);
    CAPTURE(int(kind), wrong, p, r, r_cv, d, d_cv);
    CHECK(r < r_cv);
    CHECK(d < d_cv);
  }
}
