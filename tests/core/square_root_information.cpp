#include "plumbline/core/square_root_information.hpp"

#include <limits>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("square_root_information: whitens", "", float, double) {
  using S = TestType;
  testing::Gaussian normal(1);
  for (int run = 0; run < 20; ++run) {
    Mat<double, 6, 6> A;
    for (int i = 0; i < 6; ++i) A.col(i) = normal.vector<6>();
    const Mat<double, 6, 6> covariance = A * A.transpose() + 0.1 * Mat<double, 6, 6>::Identity();
    const Result<Mat<S, 6, 6>> L = square_root_information(Mat<S, 6, 6>(covariance.cast<S>()));
    REQUIRE(L);
    const Mat<double, 6, 6> Ld = L->template cast<double>();
    REQUIRE((Ld * covariance * Ld.transpose() - Mat<double, 6, 6>::Identity()).norm() <
            (std::is_same_v<S, float> ? 1e-3 : 1e-12));
    REQUIRE(L->template triangularView<Eigen::StrictlyUpper>().toDenseMatrix().norm() == 0);
  }
}

TEST_CASE("square_root_information: refuses what is no covariance") {
  Mat<double, 3, 3> covariance = Mat<double, 3, 3>::Identity();
  REQUIRE(square_root_information(covariance));
  for (const double bad :
       {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    covariance(1, 1) = bad;
    REQUIRE(square_root_information(covariance).error() == Error::not_positive_definite);
  }
  covariance(1, 1) = 1;
  covariance(2, 1) = 2;
  REQUIRE(!square_root_information(covariance));
}
