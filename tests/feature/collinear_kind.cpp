// Lines through points: their rows against numeric Jacobians, what stands in for a segment, and the points on them.
#include "plumbline/feature/collinear_kind.hpp"

#include <Eigen/LU>
#include <cmath>

#include "catch.hpp"
#include "feature/recorded_rows.hpp"
#include "feature/seen_collinear.hpp"
#include "plumbline/feature/window_terms.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;

namespace {

template <class S>
using Scene = test::SeenCollinear<S>;
template <class S>
using Kind = typename Scene<S>::LineKind;
using DepthSensors = Rig<Rgbd<Pinhole<double>, 64 * 64>>;

static_assert(FeatureKind<Kind<float>> && FeatureKind<Kind<double>>);
// A depth camera gives no depth to these lines: their points have it.
static_assert(Kind<double>::rows_per_view == 2 && CollinearKind<DepthSensors>::rows_per_view == 2);
static_assert(LineKind<DepthSensors>::rows_per_view == 4 && CollinearKind<DepthSensors>::depth_dim == 0);
// Points lie on them, lines do not.
static_assert(Kind<double>::can_contain<PointKind<DepthSensors>> && !Kind<double>::can_contain<LineKind<DepthSensors>>);

/// Whitened residual of a segment by the distance of its endpoints to the image of the line, in double.
template <class Observation>
Vec<double, 2> residual(const Observation& seen, const Plucker<double>& in_camera) {
  const auto pixels = test::pixels_of(seen);
  const Vec<double, 3> n = in_camera.n.normalized();
  const Mat<double, 2, 2> covariance = test::pixels_covariance(), L = *square_root_information(covariance);
  return L * Vec<double, 2>(pixels.px_per_rad[0] * n.dot(pixels.bearing_start),
                            pixels.px_per_rad[1] * n.dot(pixels.bearing_end));
}

}  // namespace

TEMPLATE_TEST_CASE("collinear_kind: rows of a segment are those of its endpoints, with numeric Jacobians", "", float,
                   double) {
  using S = TestType;
  constexpr double tolerance = std::is_same_v<S, float> ? 2e-3 : 1e-6;
  Scene<S> scene;
  int views = 0;
  for (auto& line : scene.lines->landmarks()) {
    line.geometry.line = line.geometry.line.plus(Vec<S, 4>(S(5e-4) * Vec<S, 4>(1, -1, 1, -1)));
    const Line3<double> in_anchor = line.geometry.line.template cast<double>();
    const auto T_world_cam = [&](int k) {
      return scene.window.T_world_body(k).template cast<double>() * scene.T_body_cam;
    };
    for (int k = line.anchor + 1; k < Scene<S>::used; ++k) {
      const auto& seen = line.observations[std::size_t(k)];
      REQUIRE(seen.valid);
      const SE3<double> T_world_target = scene.window.T_world_body(k).template cast<double>();
      const auto at = [&](const SE3<double>& T_world_body, const Line3<double>& x) {
        return residual(seen, (T_world_body * scene.T_body_cam).inverse() * T_world_cam(line.anchor) * x.plucker());
      };
      const RelativeView<S> view(scene.window.T_world_body(line.anchor), scene.window.T_world_body(k),
                                 scene.T_body_cam.template cast<S>());
      test::RecordedRows<Kind<S>> rows;
      const typename Kind<S>::Linearized linearized(line.geometry);
      const double cost = Kind<S>::add_view(scene.rig, linearized, seen, view, k, rows);
      const Vec<double, 2> r = at(T_world_target, in_anchor);
      REQUIRE(r.norm() < 2.4);  // the kernel is quadratic there
      REQUIRE(rows.rows() == 2);
      REQUIRE(rows.slot == k);
      CHECK((rows.r - r).norm() < 100 * tolerance);
      CHECK(cost == Approx(r.squaredNorm() / 2).margin(100 * tolerance));
      CHECK(Kind<S>::cost(scene.rig, typename Kind<S>::InAnchor(line.geometry), seen, view) ==
            Approx(cost).epsilon(1e-4).margin(1e-4));
      const Mat<double, 2, 6> J_pose =
          testing::numeric_jacobian<2, 6>([&](const SE3<double>& T) { return at(T, in_anchor); }, T_world_target);
      Mat<double, 2, 4> J_line;
      for (int c = 0; c < 4; ++c) {
        const Vec<double, 4> d = 1e-5 * Vec<double, 4>::Unit(c);
        J_line.col(c) = (at(T_world_target, in_anchor.plus(d)) - at(T_world_target, in_anchor.plus(-d))) / 2e-5;
      }
      CHECK((rows.J_target - J_pose).norm() < tolerance * J_pose.norm());
      CHECK((rows.J_landmark - J_line).norm() < tolerance * J_line.norm());
      ++views;
    }
  }
  REQUIRE(views == 15);
}

TEMPLATE_TEST_CASE("collinear_kind: what points stand in for is in the window as points alone", "", float, double) {
  using S = TestType;
  Scene<S> scene;
  auto& line = scene.lines->landmarks()[0];
  const RelativeView<S> view(scene.window.T_world_body(0), scene.window.T_world_body(2),
                             scene.T_body_cam.template cast<S>());
  const typename Kind<S>::Linearized linearized(line.geometry);
  const typename Kind<S>::InAnchor in_anchor(line.geometry);
  auto seen = line.observations[2];
  seen.pixels.measured.bearing_end = (seen.pixels.measured.bearing_end + Vec<S, 3>(S(0.1), S(-0.1), 0)).normalized();
  test::RecordedRows<Kind<S>> rows;
  // A segment is off by so much that it is dropped; members are not judged here.
  auto segment = seen;
  REQUIRE(Kind<S>::add_view(scene.rig, linearized, segment, view, 2, rows) > 10);
  REQUIRE(rows.rows() == 2);
  REQUIRE(Kind<S>::cost(scene.rig, in_anchor, segment, view) > 10);
  Kind<S>::reject_outliers(scene.rig, in_anchor, segment, view);
  CHECK_FALSE(segment.valid);

  seen.from_points = true;
  CHECK(Kind<S>::add_view(scene.rig, linearized, seen, view, 2, rows) == 0);
  CHECK(rows.rows() == 2);
  CHECK(Kind<S>::cost(scene.rig, in_anchor, seen, view) == 0);
  Kind<S>::reject_outliers(scene.rig, in_anchor, seen, view);
  CHECK(seen.valid);
}

TEST_CASE("collinear_kind: a member errs by the straightness of edges and by how far it is beside one") {
  using Member = Kind<double>::Member;
  CHECK(Member{.id = 1}.sigma() == Approx(0.003));
  CHECK(Member{.id = 1, .offset = 0.004}.sigma() == Approx(0.005));
  CHECK(Member{.id = 1, .offset = -0.004}.sigma() == Approx(0.005));
}

TEST_CASE("collinear_kind: members are found by their id, wherever they have moved") {
  Scene<double> scene;
  auto& members = scene.lines->landmarks()[1].appearance.points;  // points 3, 4, 5
  const auto points = [&]() -> auto& { return scene.store->landmarks(); };
  for (std::size_t k = 0; k < members.size(); ++k) {
    CHECK(index_of(*scene.store, members[k]) == int(3 + k));
    CHECK(members[k].hint == int(3 + k));
  }
  points().swap_remove(3);  // the last one comes to its place
  CHECK(index_of(*scene.store, members[0]) == -1);
  auto& last = scene.lines->landmarks()[5].appearance.points[2];
  CHECK(index_of(*scene.store, last) == 3);
  CHECK(index_of(*scene.store, members[1]) == 4);
  last.hint = 1000;  // beyond the store
  CHECK(index_of(*scene.store, last) == 3);
}

TEST_CASE("collinear_kind: the points on a line are of the first kind that may lie on it") {
  Scene<double> scene;
  const LandmarkStore<LineKind<Scene<double>::Sensors>, 4, Scene<double>::slots> others(StoreOptions{});
  const Scene<double>::Store second(StoreOptions{});
  const auto& held = member_store_of<Kind<double>>(others, *scene.store, second);
  CHECK(&held == scene.store.get());
}
