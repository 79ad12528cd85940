#include "plumbline/tracking/line_fit.hpp"

#include <cstdint>

#include <Eigen/Eigenvalues>

#include "catch.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;

TEST_CASE("line_fit: mean, direction and variance are those of the eigenvectors") {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const double angle = 0.0314 * i, c = std::cos(angle), s = std::sin(angle);
    LineMoments<float> moments;
    Mat<double, 2, Eigen::Dynamic> points(2, 30);
    for (int k = 0; k < 30; ++k) {
      const double along = 40 * random.uniform() - 20, across = 2 * random.uniform() - 1;
      points.col(k) << 3 + c * along - s * across, -5 + s * along + c * across;
      moments.add(static_cast<float>(points(0, k)), static_cast<float>(points(1, k)));
    }
    const Vec<double, 2> mean = points.rowwise().mean();
    const Mat<double, 2, Eigen::Dynamic> centered = points.colwise() - mean;
    const Eigen::SelfAdjointEigenSolver<Mat<double, 2, 2>> eigen(
        Mat<double, 2, 2>(centered * centered.transpose() / 30));
    const FittedLine line = moments.line();
    REQUIRE((line.mean.cast<double>() - mean).norm() < 1e-4);
    REQUIRE(line.variance == Approx(eigen.eigenvalues()[0]).epsilon(1e-2).margin(1e-4));
    REQUIRE(std::abs(line.direction.cast<double>().dot(eigen.eigenvectors().col(1))) == Approx(1).epsilon(1e-5));
    REQUIRE(moments.is_straight(line.variance * 1.01f));
    REQUIRE_FALSE(moments.is_straight(line.variance * 0.99f));
    const Vec<float, 2> uv = line.at(7) + 2 * Vec<float, 2>(-line.direction.y(), line.direction.x());
    REQUIRE(line.along(uv) == Approx(7));
    REQUIRE(line.distance(uv) == Approx(2));
  }
}

TEST_CASE("line_fit: pixels added and taken away leave exact sums") {
  LineMoments<std::int64_t> all, some;
  for (int k = 0; k < 4000; ++k) {
    all.add(k, 2 * k, 1);
    if (k >= 3990) some.add(k, 2 * k, 1);
  }
  for (int k = 0; k < 3990; ++k) all.add(k, 2 * k, -1);
  REQUIRE(all.n == some.n);
  REQUIRE(all.xx == some.xx);
  REQUIRE(all.line().variance < 1e-3f);
  REQUIRE(std::abs(all.line().distance({3995, 7990})) < 1e-3f);
}

TEST_CASE("line_fit: axes and diagonals") {
  for (const Vec<float, 2>& d : {Vec<float, 2>(1, 0), Vec<float, 2>(0, 1), Vec<float, 2>(1, 1), Vec<float, 2>(1, -1)}) {
    LineMoments<float> moments;
    for (int k = -5; k <= 5; ++k) moments.add(static_cast<float>(k) * d.x(), static_cast<float>(k) * d.y());
    REQUIRE(std::abs(moments.line().direction.dot(d.normalized())) == Approx(1));
  }
}
