// A point's geometry, and its rows against the residual types, one landmark at a time.
#include "plumbline/feature/point_kind.hpp"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <type_traits>

#include "catch.hpp"
#include "feature/recorded_rows.hpp"
#include "feature/residuals_of.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/camera/radtan.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "residual/points.hpp"

using namespace plumbline;
using test::PointScene;
using test::RecordedRows;

namespace {

template <class S>
using RgbdKind = PointKind<Rig<Rgbd<Pinhole<S>, 64 * 64>>>;
template <class S>
using MonoKind = PointKind<Rig<Mono<Pinhole<S>, 64 * 64>>>;

// Of a rig with a global shutter no derivatives.
static_assert(sizeof(MonoKind<float>::Geometry) == 5 * sizeof(float));
static_assert(sizeof(RgbdKind<float>::Geometry) == 12 * sizeof(float));
static_assert(sizeof(MonoKind<double>::InWorld) < sizeof(RgbdKind<double>::InWorld));
static_assert(MonoKind<float>::rows_per_view == 2 && RgbdKind<float>::rows_per_view == 3);

/// A point in front of two bodies, some pixels off where the second one saw it.
template <class Kind>
struct Scene {
  using S = typename Kind::Scalar;
  typename Kind::Sensors rig{};
  typename Kind::Geometry point;
  typename Kind::Observation seen;
  SE3<S> T_body_cam, T_world_anchor, T_world_target;
  RelativeView<S> view;
  bool visible = false;

  explicit Scene(std::uint64_t seed) {
    const PointScene s(seed);
    rig.vision.camera = {S(s.camera.fx), S(s.camera.fy), S(s.camera.cx), S(s.camera.cy), {}};
    T_body_cam = s.T_body_cam.cast<S>();
    T_world_anchor = s.T_world_anchor.cast<S>();
    T_world_target = s.T_world_target.cast<S>();
    view = RelativeView<S>(T_world_anchor, T_world_target, T_body_cam);
    point.bearing = s.bearing.cast<S>();
    point.inverse_range = S(s.lambda);
    const Vec<S, 3> P = view.scaled_point(point.bearing, point.inverse_range);
    const Projection<S> projection = rig.vision.camera.project(P);
    visible = projection.valid && P.z() > S(0.1);
    if (!visible) return;
    seen.valid = true;
    seen.uv = projection.uv.template cast<float>() + Vec<float, 2>(float(seed % 7) - 3, float(seed % 5) - 2);
    seen.L << 1.5f, 0.4f, 0.0f, 0.8f;
    seen.depth.set({true, S(s.lambda) / P.z() + S(0.01), S(0.006)});
  }
};

template <class S>
constexpr double tolerance = std::is_same_v<S, float> ? 1e-4 : 1e-12;

double difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return (a - b).norm() / (1 + b.norm()); }

}  // namespace

TEMPLATE_TEST_CASE("point_kind: rows in the window are those of the residuals, whitened and weighted", "",
                   RgbdKind<float>, RgbdKind<double>, MonoKind<float>, MonoKind<double>) {
  using Kind = TestType;
  using S = typename Kind::Scalar;
  int checked = 0;
  for (std::uint64_t seed = 1; seed < 60; ++seed) {
    Scene<Kind> s(seed);
    if (!s.visible) continue;
    ++checked;
    if (seed % 3 == 0) s.seen.depth.set({});
    RecordedRows<Kind> rows, expected;
    const double cost = Kind::add_view(s.rig, s.point, s.seen, s.view, 4, rows);
    double expected_cost = 0;
    test::for_each_view_residual(Kind{}, s.rig, s.point, s.seen, s.view,
                                 [&]<class Lin, int R>(const Lin& lin, const Mat<S, R, R>& L, const Huber<S>& loss) {
                                   REQUIRE(lin.valid);
                                   const Vec<S, R> r = L * lin.r;
                                   const S squared = r.squaredNorm(), w = std::sqrt(loss.weight(squared));
                                   expected.template add<R>(4, Mat<S, R, 6>(w * L * lin.J_r_target),
                                                            Mat<S, R, 1>(w * L * lin.J_r_lambda), Vec<S, R>(w * r));
                                   expected_cost += double(loss.rho(squared)) / 2;
                                 });
    CAPTURE(seed);
    REQUIRE(rows.rows() == expected.rows());
    REQUIRE(rows.slot == 4);
    REQUIRE(difference(rows.r, expected.r) < tolerance<S>);
    REQUIRE(difference(rows.J_target, expected.J_target) < tolerance<S>);
    REQUIRE(difference(rows.J_landmark, expected.J_landmark) < tolerance<S>);
    REQUIRE(cost == Approx(expected_cost).epsilon(tolerance<S>));
    REQUIRE(Kind::cost(s.rig, s.point, s.seen, s.view) == Approx(cost).epsilon(tolerance<S>));
  }
  REQUIRE(checked > 30);
}

TEMPLATE_TEST_CASE("point_kind: the depth measured in the anchor", "", float, double) {
  using S = TestType;
  using Kind = RgbdKind<S>;
  Scene<Kind> s(1);
  s.seen.depth.set({true, s.point.inverse_range / s.point.bearing.z() + S(0.004), S(0.005)});
  RecordedRows<Kind> rows;
  const double cost = Kind::add_anchor(s.point, s.seen, rows);
  const SE3<S>& T = s.T_world_anchor;
  const auto lin = InverseDepthMeasurement<S>{s.seen.depth.get().value}.linearize(
      RelativeView<S>(T, T, s.T_body_cam), s.point.bearing, s.point.inverse_range);
  REQUIRE(rows.rows() == 1);
  REQUIRE(rows.r[0] == Approx(double(lin.r[0] / S(0.005))).epsilon(1e-3));
  REQUIRE(rows.J_landmark(0, 0) == Approx(double(lin.J_r_lambda(0) / S(0.005))).epsilon(1e-4));
  REQUIRE(cost == Approx(rows.r[0] * rows.r[0] / 2).epsilon(1e-4));
  REQUIRE(Kind::cost_in_anchor(s.point, s.seen) == cost);
  Kind::add_anchor_pixels(s.point, s.seen, rows);  // nothing that others could lean on
  Kind::add_damping(rows);
  REQUIRE(rows.rows() == 1);
  s.seen.depth.set({});
  REQUIRE(Kind::add_anchor(s.point, s.seen, rows) == 0);
  REQUIRE(rows.rows() == 1);
}

TEMPLATE_TEST_CASE("point_kind: what no frame can see has a cost and no rows, and is dropped", "", RgbdKind<float>,
                   MonoKind<double>) {
  using Kind = TestType;
  using S = typename Kind::Scalar;
  Scene<Kind> s(1);
  const SE3<S> turned =
      s.T_world_target * s.T_body_cam * SE3<S>(SO3<S>::exp({0, S(3.1), 0}), Vec<S, 3>::Zero()) * s.T_body_cam.inverse();
  const RelativeView<S> behind(s.T_world_anchor, turned, s.T_body_cam);
  RecordedRows<Kind> rows;
  const double cost = Kind::add_view(s.rig, s.point, s.seen, behind, 1, rows);
  REQUIRE(rows.rows() == 0);
  REQUIRE(cost > 50);
  REQUIRE(Kind::cost(s.rig, s.point, s.seen, behind) == cost);
  Kind::reject_outliers(s.rig, s.point, s.seen, s.view);
  REQUIRE(s.seen.valid);
  Kind::reject_outliers(s.rig, s.point, s.seen, behind);
  REQUIRE_FALSE(s.seen.valid);
  s.seen.valid = true;
  s.seen.uv.x() += 30;
  Kind::reject_outliers(s.rig, s.point, s.seen, s.view);
  REQUIRE_FALSE(s.seen.valid);
}

TEMPLATE_TEST_CASE("point_kind: rows in one frame are those of the residuals, whitened by pixel and landmark together",
                   "", RgbdKind<float>, RgbdKind<double>, MonoKind<float>, MonoKind<double>) {
  using Kind = TestType;
  using S = typename Kind::Scalar;
  const double sigma_lambda = GENERATE(0.0, 0.02);
  for (std::uint64_t seed : {1u, 2u, 3u, 5u, 6u, 7u}) {
    Scene<Kind> s(seed);
    if (!s.visible) continue;
    s.point.sigma_inverse_range = S(sigma_lambda);
    const SE3<S> T_world_anchor_cam = s.T_world_anchor * s.T_body_cam;
    const BodyView<S> body(s.T_world_target, s.T_body_cam);
    const auto in_world = Kind::in_world(s.point, s.seen, T_world_anchor_cam);
    REQUIRE((in_world.p_world - T_world_anchor_cam * Kind::middle(s.point)).norm() == 0);
    const auto pixel = Kind::pixel_rows(s.rig, body, in_world);
    const auto depth = Kind::depth_rows(body, in_world);
    REQUIRE(Kind::has_depth(in_world) == Kind::Sensors::has_depth);
    REQUIRE(pixel.valid);
    test::for_each_world_residual(
        Kind{}, s.rig, s.point, s.seen, T_world_anchor_cam, body,
        [&]<class Lin, int R>(const Lin& lin, const Mat<S, R, R>& L, const Huber<S>&) {
          const Vec<double, R> r = lin.r.template cast<double>();
          const Mat<double, R, 6> J = lin.J_r_pose.template cast<double>();
          const Mat<double, R, R> Ld = L.template cast<double>();
          const Vec<double, R> j = (lin.J_r_point * in_world.sigma_world).template cast<double>();
          const Mat<double, R, R> covariance = (Ld.transpose() * Ld).inverse() + j * j.transpose(),
                                  information = covariance.inverse();  // (10)
          const auto compare = [&](const auto& rows) {
            const Eigen::MatrixXd found = rows.J.template leftCols<6>().template cast<double>();
            const Eigen::VectorXd e = rows.r.template cast<double>();
            REQUIRE(difference(found.transpose() * found, J.transpose() * information * J) < 20 * tolerance<S>);
            REQUIRE(difference(found.transpose() * e, J.transpose() * information * r) < 20 * tolerance<S>);
          };
          if constexpr (R == 2) {
            compare(pixel);
            REQUIRE(Kind::error_px(s.rig, body, in_world) == Approx(r.norm()));
          } else {
            compare(depth);
          }
        });
  }
}

TEMPLATE_TEST_CASE("point_kind: geometry", "", RgbdKind<float>, RgbdKind<double>, MonoKind<double>) {
  using Kind = TestType;
  using S = typename Kind::Scalar;
  typename Kind::Geometry point;
  point.bearing = Vec<S, 3>(0, S(0.6), S(0.8));
  point.inverse_range = S(0.5);
  REQUIRE((Kind::middle(point) - Vec<S, 3>(0, S(1.2), S(1.6))).norm() < S(1e-6));
  REQUIRE(Kind::inverse_range(point) == S(0.5));
  REQUIRE(Kind::set_covariance(point, {}, nullptr));
  REQUIRE(point.sigma_inverse_range == 0);
  const Mat<S, 1, 1> covariance(S(0.04));
  REQUIRE(Kind::set_covariance(point, {}, &covariance));
  REQUIRE(point.sigma_inverse_range == Approx(0.2));
  Kind::rescale(point, S(4));
  REQUIRE((Kind::middle(point) - Vec<S, 3>(0, S(4.8), S(6.4))).norm() < S(1e-5));
  REQUIRE(point.sigma_inverse_range == Approx(0.05));

  point.derivative.set({Vec<S, 3>(2, 0, 0)});
  Kind::change_readout(point, {}, S(0.01));
  REQUIRE(point.bearing.norm() == Approx(1));
  REQUIRE(point.bearing.x() == Approx(Kind::Sensors::rolls ? 0.02 : 0.0).margin(1e-5));

  typename Kind::Observation then, now;
  now.pixel = Vec<float, 2>(3, 4);
  REQUIRE(Kind::motion_px(then, now) == Approx(5));
}

TEMPLATE_TEST_CASE("point_kind: inverse ranges stay where a point can be", "", float, double) {
  using S = TestType;
  using Kind = MonoKind<S>;
  typename Kind::Geometry point;
  point.inverse_range = S(0.5);
  Kind::step(point, Vec<S, 1>(S(0.25)));
  REQUIRE(point.inverse_range == S(0.75));
  Kind::step(point, Vec<S, 1>(S(-10)));
  REQUIRE(point.inverse_range == Kind::lambda_min);
  Kind::step(point, Vec<S, 1>(S(1000)));
  REQUIRE(point.inverse_range == Kind::lambda_max);
  point.inverse_range = S(1e-9);  // what takes no step stays where it is
  Kind::step(point, Vec<S, 1>(S(0)));
  REQUIRE(point.inverse_range == S(1e-9));
}
