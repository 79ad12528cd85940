#include "plumbline/map/graph_poses.hpp"

#include <type_traits>

#include "catch.hpp"
#include "plumbline/residual/relative_pose.hpp"
#include "plumbline/residual/relative_pose_yaw.hpp"
#include "plumbline/residual/relative_sim3.hpp"

using namespace plumbline;

namespace {

template <class S>
SE3<S> pose() {
  return SE3<S>(SO3<S>::exp({S(0.2), S(-0.3), S(0.9)}), {S(1), S(-2), S(0.5)});
}
template <class S>
Mat<S, 6, 6> covariance() {
  Mat<S, 6, 6> A;
  for (int i = 0; i < 36; ++i) A(i / 6, i % 6) = S((i * 7) % 11) / 100;
  return A * A.transpose() + S(0.01) * identity<S, 6>();
}
template <class S>
constexpr S tolerance = std::is_same_v<S, float> ? S(1e-5) : S(1e-13);

}  // namespace

TEMPLATE_TEST_CASE("graph_poses: a pose of the window comes back, whatever the graph has", "",
                   RelativePoseResidual<float>, RelativePoseYawResidual<double>, RelativeSim3Residual<double>,
                   RelativeSim3Residual<float>) {
  using Poses = GraphPoses<TestType>;
  using S = typename Poses::S;
  const SE3<S> T = pose<S>();
  const Sim3<S> back = Poses::to_sim3(Poses::from_sim3(Poses::to_sim3(Poses::to_pose(T))));
  CHECK(norm(Vec<S, 3>(back.t() - T.p())) < tolerance<S>);
  CHECK((back.R() - T.R()).norm() < tolerance<S>);
  CHECK(back.scale() == S(1));
}

TEST_CASE("graph_poses: a camera alone has a scale, other rigs drop it") {
  using Alone = GraphPoses<RelativeSim3Residual<double>>;
  using WithDepth = GraphPoses<RelativePoseResidual<double>>;
  using WithImu = GraphPoses<RelativePoseYawResidual<double>>;
  STATIC_REQUIRE((Alone::has_scale && !WithDepth::has_scale && !WithImu::has_scale));
  STATIC_REQUIRE((!Alone::has_gravity && !WithDepth::has_gravity && WithImu::has_gravity));
  const Sim3<double> X(2, pose<double>().rotation(), pose<double>().p());
  CHECK(Alone::from_sim3(X).scale() == 2);
  CHECK(Alone::to_pose(pose<double>(), 3).scale() == Approx(3));
  CHECK(WithDepth::to_sim3(WithDepth::from_sim3(X)).scale() == 1);
  CHECK(WithDepth::from_sim3(X).p() == X.t());
}

TEST_CASE("graph_poses: the covariance of an edge is that of the increments that its residual has") {
  const Mat<double, 6, 6> P = covariance<double>();
  CHECK(GraphPoses<RelativePoseResidual<double>>::of_increment(P, pose<double>(), 0.1) == P);
  const Mat<double, 7, 7> alone =
      GraphPoses<RelativeSim3Residual<double>>::of_increment(P, Sim3<double>(pose<double>()), 0.1);
  CHECK(block<6, 6>(alone, 0, 0) == P);
  CHECK(alone(6, 6) == Approx(0.01));
  CHECK(alone.topRightCorner<6, 1>().isZero(0));
  // Of a level body the heading is its rotation about z: rows and columns of z and of the position.
  const SE3<double> level(SO3<double>::exp({0, 0, 0.7}), {1, 2, 3});
  const Mat<double, 4, 4> upright = GraphPoses<RelativePoseYawResidual<double>>::of_increment(P, level, 0.1);
  CHECK((upright - P.bottomRightCorner<4, 4>()).norm() < 1e-12);
}
