#include "plumbline/feature/point_landmark.hpp"

#include "catch.hpp"

using namespace plumbline;

TEST_CASE("point_landmark: whitening is the square root of the information") {
  Mat<float, 2, 2> A;
  A << 900, 300, 300, 400;
  const Mat<float, 2, 2> L = whitening_of(A, 0.5f, 10);
  const Mat<float, 2, 2> sigma = 0.25f * Mat<float, 2, 2>::Identity() + 100 * A.inverse();
  REQUIRE((L.transpose() * L - sigma.inverse()).norm() < 1e-4f * sigma.inverse().norm());
}

TEST_CASE("point_landmark: what slides along an edge does not count along it") {
  Mat<float, 2, 2> edge;
  edge << 10000, 0, 0, 1;
  const Mat<float, 2, 2> L = whitening_of(edge, 0.5f, 10);
  REQUIRE((L * Vec<float, 2>(1, 0)).norm() > 1.5f);
  REQUIRE((L * Vec<float, 2>(0, 1)).norm() < 0.11f);
}

TEST_CASE("point_landmark: observations and position") {
  PointLandmark<double, 4> landmark;
  REQUIRE(landmark.observation_count() == 0);
  landmark.observations[1].valid = landmark.observations[3].valid = true;
  REQUIRE(landmark.observation_count() == 2);
  landmark.bearing = Vec<double, 3>(0, 0.6, 0.8);
  landmark.inverse_range = 0.5;
  REQUIRE((landmark.p_anchor_cam() - Vec<double, 3>(0, 1.2, 1.6)).norm() < 1e-15);
}
