// The covariance of a keyframe's pose in the map, against samples of the poses.
#include "plumbline/map/map_correction.hpp"

#include <cstdint>
#include <limits>
#include <vector>

#include "catch.hpp"
#include "laps.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/map/pose_graph.hpp"
#include "plumbline/residual/relative_pose.hpp"
#include "plumbline/residual/relative_pose_yaw.hpp"
#include "plumbline/residual/relative_sim3.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

/// Keyframes 10, 20, 30, ... of a chain with known odometry.
template <class ResidualT>
struct Chain {
  using Residual = ResidualT;
  using Pose = typename Residual::Pose;
  using Graph = PoseGraph<Residual, 8, 2>;
  using Covariance = typename Graph::Covariance;
  static constexpr int none = -1;
  struct Keyframe {
    std::uint32_t id;
  };
  std::vector<Keyframe> keyframes;
  Graph chain;

  const Graph& graph() const { return chain; }
  int size() const { return int(keyframes.size()); }
  const Keyframe& keyframe(int k) const { return keyframes[std::size_t(k)]; }
  int find(std::uint32_t id) const {
    for (int k = 0; k < size(); ++k) {
      if (keyframe(k).id == id) return k;
    }
    return none;
  }
  static Covariance noise(double sigma) {
    Covariance P = zeros<Covariance>();
    for (int k = 0; k < Residual::dim; ++k) P(k, k) = sigma * sigma * (1 + k);
    return P;
  }
  static Pose step() {
    const SE3<double> T(SO3<double>::exp({0, 0, 0.4}), {1.5, 0.3, -0.2});
    if constexpr (Residual::dim == 7) {
      return Pose(1.0, T.rotation(), T.p());
    } else {
      return T;
    }
  }
  Chain() {
    keyframes.push_back({10});
    REQUIRE(chain.add_first(Pose()) == PoseGraphInsertion::inserted);
    for (std::uint32_t n = 2; n <= 5; ++n) {
      keyframes.push_back({10 * n});
      REQUIRE(chain.add_node(chain.pose(chain.nodes() - 1) * step(), step(), noise(0.004)) ==
              PoseGraphInsertion::inserted);
    }
  }
};

}  // namespace

TEMPLATE_TEST_CASE("map_correction: the covariance is that of samples of pose and odometry", "",
                   RelativePoseResidual<double>, RelativePoseYawResidual<double>, RelativeSim3Residual<double>) {
  using Residual = TestType;
  using Places = Chain<Residual>;
  using Covariance = typename Places::Covariance;
  const Places places;
  MapCorrection<Places> correction;
  Covariance P, sampled = zeros<Covariance>();
  REQUIRE_FALSE(correction.covariance(places, 4, P));
  const Covariance P_n = Places::noise(0.006);
  correction.set(20, P_n, true);
  REQUIRE(correction.covariance(places, 4, P));

  testing::Gaussian gaussian(3);
  const auto draw = [&](const Covariance& of) {
    Vec<double, Residual::dim> d;
    for (int k = 0; k < Residual::dim; ++k) d[k] = std::sqrt(of(k, k)) * gaussian();
    return d;
  };
  constexpr int samples = 40'000;
  for (int n = 0; n < samples; ++n) {
    auto T = Residual::moved(places.chain.pose(1), draw(P_n));
    for (int k = 2; k <= 4; ++k) T = Residual::moved(T * Places::step(), draw(Places::noise(0.004)));
    // The error of T as an increment of the true pose: the residual of T against the identity measured there.
    const auto r = Residual{typename Residual::Pose()}.residual(places.chain.pose(4), T);
    for (int a = 0; a < Residual::dim; ++a)
      for (int b = 0; b < Residual::dim; ++b) sampled(a, b) += r[a] * r[b] / samples;
  }
  for (int a = 0; a < Residual::dim; ++a) {
    for (int b = 0; b < Residual::dim; ++b) {
      INFO(a << ' ' << b);
      CHECK(sampled(a, b) == Approx(P(a, b)).margin(0.04 * std::sqrt(P(a, a) * P(b, b))));
    }
  }
}

TEST_CASE("map_correction: a keyframe that goes hands its covariance on; unknown ones are said to be") {
  using Places = Chain<RelativePoseResidual<double>>;
  Places places;
  MapCorrection<Places> correction;
  Places::Covariance before, after;
  correction.set(20, Places::noise(0.01), true);
  CHECK_FALSE(correction.covariance(places, 0, before));
  REQUIRE(correction.covariance(places, 3, before));
  correction.before_removal(places, 1);
  REQUIRE(correction.covariance(places, 3, after));
  for (int a = 0; a < 6; ++a)
    for (int b = 0; b < 6; ++b) CHECK(after(a, b) == Approx(before(a, b)).margin(1e-15));
  CHECK_FALSE(correction.covariance(places, 1, after));  // it refers to keyframe 30 now

  correction.set(30, Places::noise(std::numeric_limits<double>::quiet_NaN()), true);
  CHECK_FALSE(correction.covariance(places, 3, after));
  correction.set(30, Places::noise(0.01), false);
  CHECK_FALSE(correction.covariance(places, 3, after));
  correction.set(50, Places::noise(0.01), true);
  CHECK(correction.covariance(places, 4, after));
  correction.before_removal(places, 4);  // the last one
  CHECK_FALSE(correction.covariance(places, 4, after));
}

TEST_CASE("map_correction: after loops a map knows the newest keyframe better than the odometry does") {
  using Residual = RelativePoseResidual<double>;
  test::Laps<Residual> laps(2);
  typename test::Laps<Residual>::Core::Covariance P;
  laps.step();
  CHECK_FALSE(laps.map->covariance_in_map(P));
  for (int k = 0; k < 2 * test::per_lap; ++k) laps.step();
  REQUIRE(laps.map->covariance_in_map(P));
  const auto& graph = laps.map->places().graph();
  OdometryChain<Residual> odometry(graph.pose(0));
  for (int k = 1; k < graph.nodes(); ++k)
    odometry.append(graph.odometry(k).residual.measured, graph.odometry(k).covariance());
  for (int k = 0; k < 6; ++k) {
    CHECK(P(k, k) > 0);
    CHECK(P(k, k) < odometry.covariance()(k, k) / 4);
  }
}
