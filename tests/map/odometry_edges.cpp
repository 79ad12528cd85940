// Edges between keyframes whose covariances are known in closed form.
#include "plumbline/map/odometry_edges.hpp"

#include <vector>

#include "catch.hpp"
#include "plumbline/map/place_keyframe.hpp"

using namespace plumbline;

namespace {

using Keyframe = PlaceKeyframe<double, 1>;

Mat<double, 6, 6> isotropic(double variance) {
  Mat<double, 6, 6> P = zeros<double, 6, 6>();
  for (int k = 0; k < 6; ++k) P(k, k) = variance;
  return P;
}
/// Keyframes 1 m apart along x, whose position is `variance_of(k)` uncertain.
template <class VarianceOf>
std::vector<Keyframe> line(int count, VarianceOf&& variance_of) {
  std::vector<Keyframe> out(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) {
    Keyframe& keyframe = out[std::size_t(k)];
    keyframe.T_world_body = SE3<double>(SO3<double>(), {double(k), 0, 0});
    for (int n = 3; n < 6; ++n) keyframe.covariance(n, n) = variance_of(k);
  }
  return out;
}
auto in(std::vector<Keyframe>& keyframes) {
  return [&](int k) -> Keyframe& { return keyframes[std::size_t(k)]; };
}
constexpr OdometryEdgeOptions no_floor{0, 0, 50, 10, 1e3};
/// Measures all of them.
void measure_all(std::vector<Keyframe>& keyframes, const OdometryEdgeOptions& options) {
  const OdometryEdges<Keyframe> edges(options);
  for (int k = 1; k < int(keyframes.size()); ++k) edges.measure(in(keyframes), k);
}

}  // namespace

TEST_CASE("odometry_edges: pose and mean growth of the covariance") {
  // Each second keyframe seems to be as certain as the one before: the growth is 2e-4 every two.
  auto keyframes = line(9, [](int k) { return 1e-4 * (2 * (k / 2)); });
  measure_all(keyframes, no_floor);
  const Keyframe& last = keyframes.back();
  CHECK(norm(Vec<double, 3>(last.T_before.p() - Vec<double, 3>(1, 0, 0))) < 1e-15);
  for (int n = 3; n < 6; ++n) CHECK(last.Q(n, n) == Approx(1e-4).epsilon(1e-12));
  CHECK(last.Q(0, 0) == 0);
}

TEST_CASE("odometry_edges: a covariance that shrinks leaves the floor alone") {
  auto keyframes = line(4, [](int k) { return 1e-4 * (4 - k); });
  measure_all(keyframes, {1e-3, 2e-3, 50, 10, 1e3});
  for (int n = 0; n < 6; ++n) CHECK(keyframes.back().Q(n, n) == Approx(n < 3 ? 1e-6 : 4e-6).epsilon(1e-9));
}

TEST_CASE("odometry_edges: the growth of an outage is kept whole, and the mean begins again") {
  auto keyframes = line(12, [](int k) { return 1e-4 * k + (k >= 8 ? 0.04 : 0); });
  measure_all(keyframes, no_floor);
  const auto variance = [&](int k) { return keyframes[std::size_t(k)].Q(3, 3); };
  CHECK(variance(7) == Approx(1e-4).epsilon(1e-9));
  CHECK(variance(8) == Approx(0.0401).epsilon(1e-9));
  CHECK(keyframes[8].begins_mean);
  CHECK(variance(11) == Approx(1e-4).epsilon(1e-9));
}

TEST_CASE("odometry_edges: a new world has an edge without information") {
  auto keyframes = line(3, [](int) { return 1e-4; });
  keyframes[2].world = 1;
  keyframes[2].Q = isotropic(1e-6);
  keyframes[2].is_known = true;  // of another world
  measure_all(keyframes, no_floor);
  CHECK(keyframes[2].Q(0, 0) == 100);
  CHECK(keyframes[2].Q(5, 5) == 1e6);
}

TEST_CASE("odometry_edges: what the window knows of an edge is taken") {
  auto keyframes = line(3, [](int k) { return 1e-2 * k; });
  keyframes[2].Q = isotropic(3e-6);
  keyframes[2].is_known = true;
  measure_all(keyframes, {1e-3, 1e-3, 50, 10, 1e3});
  CHECK(keyframes[2].Q(4, 4) == 3e-6);
  CHECK(keyframes[1].Q(4, 4) == Approx(1e-2 + 1e-6));
}

TEST_CASE("odometry_edges: an edge that the window has not told yet has the mean of those before it") {
  auto keyframes = line(8, [](int k) { return 1e-2 * k; });
  for (const int k : {1, 2, 3, 4}) {
    keyframes[std::size_t(k)].Q = isotropic(1e-6 * k);
    keyframes[std::size_t(k)].is_known = true;
  }
  measure_all(keyframes, no_floor);
  for (const int k : {5, 6, 7}) CHECK(keyframes[std::size_t(k)].Q(3, 3) == Approx(2.5e-6).epsilon(1e-9));

  // Not over the border of a world, and not in place of the growth of an outage.
  for (std::size_t k = 5; k < 8; ++k) keyframes[k].world = 1;
  measure_all(keyframes, no_floor);
  CHECK(keyframes[6].Q(3, 3) == Approx(1e-2).epsilon(1e-9));
  for (std::size_t k = 5; k < 8; ++k) keyframes[k].world = 0;
  for (std::size_t k = 6; k < 8; ++k) {
    for (int n = 3; n < 6; ++n) keyframes[k].covariance(n, n) += 10;
  }
  measure_all(keyframes, no_floor);
  CHECK(keyframes[6].begins_mean);
  CHECK(keyframes[6].Q(3, 3) > 10);
}

TEST_CASE("odometry_edges: keyframes of the window are as certain as a newer one, retired ones stay") {
  auto keyframes = line(4, [](int k) { return k == 3 ? 1e-4 : 1e-2; });
  keyframes[0].is_retired = true;
  OdometryEdges<Keyframe>::carry_back(in(keyframes), 3);
  CHECK(keyframes[2].covariance(3, 3) == 1e-4);
  CHECK(keyframes[1].covariance(3, 3) == 1e-4);
  CHECK(keyframes[0].covariance(3, 3) == 1e-2);
}
