#include "plumbline/testing/simulated_world.hpp"

#include <cmath>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/testing/rig.hpp"
#include "plumbline/testing/trajectory.hpp"

using namespace plumbline;
using namespace plumbline::testing;

TEMPLATE_TEST_CASE("simulated_world: views are projections of the features, plus noise of the stated size", "", float,
                   double) {
  using S = TestType;
  const Pinhole<S> camera{S(535), S(535), S(319.5), S(239.5)};
  const SimulatedWorld<Pinhole<S>> world(camera, 640, 480);
  const Trajectory trajectory = *Trajectory::for_scene("room");
  const double tolerance = std::is_same_v<S, float> ? 1e-3 : 1e-10;
  double uv2 = 0, inverse_depth2 = 0;
  int count = 0, segments = 0;
  for (std::uint64_t i = 0; i < 100; ++i) {
    const SE3<double> T_world_cam = trajectory.at(0.2 * double(i)).T_world_body * simulated_T_body_camera();
    const std::vector<PointView> views = world.observe_points(T_world_cam, i);
    REQUIRE(views.size() > 30);
    for (const PointView& view : views) {
      const Vec<double, 3> p = T_world_cam.inverse() * world.points()[std::size_t(view.id)];
      REQUIRE(std::abs(view.exact.uv.x() - (535 * p.x() / p.z() + 319.5)) < tolerance);
      REQUIRE(std::abs(view.exact.uv.y() - (535 * p.y() / p.z() + 239.5)) < tolerance);
      REQUIRE(view.exact.inverse_depth == Approx(1 / p.z()));
      uv2 += (view.measured.uv - view.exact.uv).squaredNorm() / 2;
      inverse_depth2 += std::pow(view.measured.inverse_depth - view.exact.inverse_depth, 2);
      ++count;
    }
    for (const SegmentView& view : world.observe_segments(T_world_cam, i)) {
      const Vec<double, 3> p = T_world_cam.inverse() * world.segments()[std::size_t(view.id)].end;
      REQUIRE(std::abs(view.exact_end.uv.x() - (535 * p.x() / p.z() + 319.5)) < tolerance);
      REQUIRE((view.measured_start.uv - view.exact_start.uv).norm() > 0);
      ++segments;
    }
  }
  REQUIRE(segments > 100);
  REQUIRE(std::sqrt(uv2 / count) == Approx(1).epsilon(0.05));
  REQUIRE(std::sqrt(inverse_depth2 / count) == Approx(1.5e-3).epsilon(0.05));
}

TEST_CASE("simulated_world: deterministic by seed, and inside the room") {
  const Pinhole<double> camera{535, 535, 319.5, 239.5};
  SimulatedWorldOptions options;
  options.seed = 5;
  const SimulatedWorld<Pinhole<double>> a(camera, 640, 480, options), b(camera, 640, 480, options), c(camera, 640, 480);
  REQUIRE(a.points() == b.points());
  REQUIRE(a.points() != c.points());
  const SE3<double> T_world_cam = Trajectory::for_scene("room")->at(3).T_world_body * simulated_T_body_camera();
  const std::vector<PointView> first = a.observe_points(T_world_cam, 2), again = b.observe_points(T_world_cam, 2);
  REQUIRE(first.size() == again.size());
  for (std::size_t i = 0; i < first.size(); ++i) REQUIRE(first[i].measured.uv == again[i].measured.uv);
  REQUIRE(first[0].measured.uv != a.observe_points(T_world_cam, 3)[0].measured.uv);
  for (const Segment& s : a.segments()) {
    for (const Vec<double, 3>& p : {s.start, s.end}) REQUIRE((std::abs(p.x()) <= 3.2 && p.z() >= 0 && p.z() <= 2.7));
    REQUIRE((s.end - s.start).norm() >= 0.3);
  }
}
