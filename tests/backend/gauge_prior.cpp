#include "plumbline/backend/gauge_prior.hpp"

#include "catch.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/state/layout.hpp"

using namespace plumbline;

namespace {
WindowOptions options() {
  WindowOptions out;
  out.sigma_first_rotation = 0.5;
  out.sigma_first_position = 0.25;
  return out;
}
}  // namespace

TEST_CASE("gauge_prior: without gravity the whole pose is fixed, and nothing else of the state") {
  const Mat<double, 6, 15> J = pose_gauge<InertialLayout>(options());
  Vec<double, 6> diagonal;
  diagonal << 2, 2, 2, 4, 4, 4;
  CHECK(J.leftCols<6>() == Mat<double, 6, 6>(diagonal.asDiagonal()));
  CHECK(J.rightCols<9>().isZero(0));
}

TEST_CASE("gauge_prior: with gravity a turn about the vertical is fixed, a tilt is not") {
  const SO3<double> R_world_body = SO3<double>::exp({0.7, -0.4, 1.9});
  Mat<double, 2, 15> rest = Mat<double, 2, 15>::Random();
  const Mat<double, 6, 15> J = heading_gauge<InertialLayout>(options(), R_world_body.matrix(), rest);
  const auto rows_of = [&](const Vec<double, 3>& axis_world, const Vec<double, 3>& dp) {
    Vec<double, 15> e = Vec<double, 15>::Zero();
    e.head<3>() = R_world_body.inverse() * axis_world;  // a rotation about that axis, in the body
    e.segment<3>(3) = dp;
    return Vec<double, 4>((J * e).head<4>());
  };
  CHECK(rows_of({1, 0, 0}, {0, 0, 0}).norm() < 1e-12);
  CHECK(rows_of({0, 1, 0}, {0, 0, 0}).norm() < 1e-12);
  CHECK((rows_of({0, 0, 1}, {0, 0, 0}) - Vec<double, 4>(0, 0, 0, 2)).norm() < 1e-12);
  CHECK((rows_of({0, 0, 0}, {1, 2, 3}) - Vec<double, 4>(4, 8, 12, 0)).norm() < 1e-12);
  CHECK(J.bottomRows<2>() == rest);
}
