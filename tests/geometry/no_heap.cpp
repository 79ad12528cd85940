// Poses with a known gravity direction do not allocate.
#include "allocation_counter.hpp"

#include "catch.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/geometry/gravity_pose_ransac.hpp"

using namespace plumbline;
using test::allocations_of;

TEMPLATE_TEST_CASE("no_heap: poses with a known gravity direction", "", float, double) {
  using S = TestType;
  Random random(1);
  FixedVector<PoseCorrespondence<S>, 40> correspondences;
  std::array<GravityPosePoint<S>, 40> points;
  const SE3<S> T(SO3<S>::exp({S(0.4), S(-0.3), S(0.9)}), Vec<S, 3>(S(1), S(2), S(0.5)));
  const Vec<S, 3> up = T.rotation() * Vec<S, 3>(0, 0, 1);
  for (std::size_t i = 0; i < 40; ++i) {
    const S z = S(1 + 4 * random.uniform());
    const Vec<S, 3> p(z * S(random.uniform() - 0.5), z * S(random.uniform() - 0.5), z);
    points[i] = {normalized(p), T.inverse() * p};
    const Vec<S, 3> bearing = i % 3 == 0 ? Vec<S, 3>(0, 0, 1) : points[i].bearing;
    correspondences.push_back({bearing, points[i].p_world, S(1e-3)});
  }
  bool ok = true;
  const long count = allocations_of([&] {
    const GravityPoseLine<S> line{normalized(Vec<S, 3>(points[1].bearing.cross(points[2].bearing))),
                                  {points[1].p_world, points[2].p_world}};
    ok = ok && !gravity_pose(up, points[0], line).empty();
    ok = ok && gravity_pose_least_squares<S>(up, points, {&line, 1}).valid;
    ok = ok && ransac_gravity_pose(correspondences, up, SE3<S>()).valid;
  });
  REQUIRE(ok);
  REQUIRE(count == 0);
}
