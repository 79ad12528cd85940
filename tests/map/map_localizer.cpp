// Loops as measurements of the pose in a map that stays: consistency of the filter, and what it leaves out.
#include "plumbline/map/map_localizer.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "catch.hpp"
#include "plumbline/map/pose_graph.hpp"
#include "plumbline/residual/relative_pose.hpp"
#include "plumbline/residual/relative_pose_yaw.hpp"
#include "plumbline/residual/relative_sim3.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

/// Keyframes 1 to 3 are the map, known exactly; 4 to 9 are of the run, and their odometry has noise.
template <class ResidualT>
struct Run {
  using Residual = ResidualT;
  using S = typename Residual::Scalar;
  using Pose = typename Residual::Pose;
  using Graph = PoseGraph<Residual, 12, 2>;
  using Covariance = typename Graph::Covariance;
  static constexpr int none = -1, dim = Residual::dim, of_map = 3;
  static constexpr double sigma_step = 0.01, sigma_loop = 0.02;
  struct Loop {
    std::uint32_t i, j;
    Pose T_i_j;
    Covariance covariance;
  };

  std::vector<std::uint32_t> ids;
  std::vector<Pose> truth;
  Graph chain;
  testing::Gaussian gaussian;

  explicit Run(std::uint64_t seed) : gaussian(seed) {
    for (std::uint32_t id = 1; id <= 9; ++id) {
      truth.push_back(id == 1 ? Pose() : truth.back() * step());
      const Pose measured = id > of_map ? Residual::moved(step(), draw(sigma_step)) : step();
      const PoseGraphInsertion answer =
          id == 1 ? chain.add_first(Pose()) : chain.add_node(truth.back(), measured, noise(sigma_step));
      REQUIRE(answer == PoseGraphInsertion::inserted);
      ids.push_back(id);
    }
  }

  const Graph& graph() const { return chain; }
  int find(std::uint32_t id) const {
    for (std::size_t k = 0; k < ids.size(); ++k) {
      if (ids[k] == id) return int(k);
    }
    return none;
  }
  static Covariance noise(double sigma) {
    Covariance P = zeros<Covariance>();
    for (int k = 0; k < dim; ++k) P(k, k) = S(sigma * sigma * (1 + 0.2 * k));
    return P;
  }
  Vec<S, dim> draw(double sigma) {
    Vec<S, dim> d;
    for (int k = 0; k < dim; ++k) d[k] = std::sqrt(noise(sigma)(k, k)) * S(gaussian());
    return d;
  }
  static Pose step() {
    const SE3<S> T(SO3<S>::exp({S(0), S(0), S(0.4)}), {S(1.5), S(0.3), S(-0.2)});
    if constexpr (dim == 7) {
      return Pose(S(1), T.rotation(), T.p());
    } else {
      return T;
    }
  }
  const Pose& true_pose(std::uint32_t id) const { return truth[id - 1]; }
  Loop loop(std::uint32_t i, std::uint32_t j, bool has_noise = true) {
    const Pose T_i_j = true_pose(i).inverse() * true_pose(j);
    return {i, j, has_noise ? Residual::moved(T_i_j, draw(sigma_loop)) : T_i_j, noise(sigma_loop)};
  }
  /// Error of a pose as an increment of the true one.
  Vec<S, dim> error_of(const Pose& T, std::uint32_t id) const { return Residual{Pose()}.residual(true_pose(id), T); }
};
constexpr LoopGateOptions gate{};

template <class Covariance>
double trace(const Covariance& P) {
  double sum = 0;
  for (int k = 0; k < int(P.rows()); ++k) sum += double(P(k, k));
  return sum;
}

}  // namespace

TEMPLATE_TEST_CASE("map_localizer: the first loop tells the pose, and a reset forgets it", "",
                   RelativePoseResidual<float>, RelativePoseYawResidual<double>, RelativeSim3Residual<double>) {
  Run<TestType> run(1);
  MapLocalizer<Run<TestType>> filter;
  CHECK_FALSE(filter.is_localized());
  const auto loop = run.loop(2, 5);
  REQUIRE(filter.add(run, loop, gate));
  CHECK(filter.is_localized());
  CHECK(double(norm(run.error_of(filter.pose(), 5))) < 8 * Run<TestType>::sigma_loop);
  CHECK(filter.covariance() == loop.covariance);
  filter.reset();
  CHECK_FALSE(filter.is_localized());
}

TEMPLATE_TEST_CASE("map_localizer: errors are as large as the covariance says, smaller than those of one loop", "",
                   RelativePoseResidual<double>, RelativePoseYawResidual<float>, RelativeSim3Residual<double>) {
  using R = Run<TestType>;
  constexpr int trials = 300;
  double nees = 0;
  int excluded = 0, used = 0;
  for (std::uint64_t seed = 1; seed <= trials; ++seed) {
    R run(seed);
    MapLocalizer<R> filter;
    bool all = true;
    for (const std::uint32_t j : {4u, 5u, 7u, 9u}) all = filter.add(run, run.loop(1 + j % 3, j), gate) && all;
    excluded += !all;
    if (!all) continue;
    ++used;
    CHECK(trace(filter.covariance()) < trace(R::noise(R::sigma_loop)));
    const auto L = square_root_information(filter.covariance());
    REQUIRE(L);
    nees += double(squared_norm(times(*L, run.error_of(filter.pose(), 9))));
  }
  nees /= used * R::dim;
  CAPTURE(nees, excluded);
  CHECK(nees > 0.85);
  CHECK(nees < 1.15);
  CHECK(excluded < trials / 20);
}

TEMPLATE_TEST_CASE("map_localizer: a wrong loop changes nothing, the third in a row begins a new filter", "",
                   RelativePoseResidual<float>, RelativePoseYawResidual<double>, RelativeSim3Residual<double>) {
  using R = Run<TestType>;
  R run(4);
  MapLocalizer<R> filter;
  REQUIRE(filter.add(run, run.loop(1, 4, false), gate));
  const auto pose = filter.pose();
  const auto P = filter.covariance();
  const auto wrong = [&](std::uint32_t j) {
    auto loop = run.loop(1, j, false);
    loop.T_i_j = loop.T_i_j * R::step();
    return loop;
  };
  CHECK_FALSE(filter.add(run, wrong(5), gate));
  CHECK(norm(run.error_of(filter.pose(), 4)) == norm(run.error_of(pose, 4)));
  CHECK(filter.covariance() == P);
  CHECK(filter.add(run, run.loop(2, 5, false), gate));  // a right one between them: they are not in a row
  CHECK_FALSE(filter.add(run, wrong(6), gate));
  CHECK_FALSE(filter.add(run, wrong(7), gate));
  CHECK(double(norm(run.error_of(filter.pose(), 5))) < 0.1);
  const auto third = wrong(8);
  CHECK(filter.add(run, third, gate));
  CHECK(filter.covariance() == third.covariance);
  CHECK(double(norm(run.error_of(filter.pose(), 8))) > 1);
}

TEMPLATE_TEST_CASE("map_localizer: without the odometry since the last loop the filter restarts; NaN is left out", "",
                   RelativePoseResidual<float>, RelativePoseYawResidual<double>, RelativeSim3Residual<double>) {
  using R = Run<TestType>;
  R run(5);
  MapLocalizer<R> filter;
  REQUIRE(filter.add(run, run.loop(1, 7, false), gate));
  const auto P = filter.covariance();
  auto poisoned = run.loop(2, 8, false);
  poisoned.covariance(0, 0) = std::numeric_limits<typename R::S>::quiet_NaN();
  CHECK_FALSE(filter.add(run, poisoned, gate));
  CHECK(filter.covariance() == P);
  auto earlier = run.loop(1, 5, false);
  earlier.covariance *= typename R::S(4);
  CHECK(filter.add(run, earlier, gate));  // of a keyframe before the one of the last loop
  CHECK(filter.covariance() == earlier.covariance);
  run.ids[4] = 99;  // keyframe 5 has left the map
  const auto later = run.loop(1, 9, false);
  CHECK(filter.add(run, later, gate));
  CHECK(filter.covariance() == later.covariance);
}
