// A line's rows against the residual types, one landmark at a time, and what becomes of a landmark.
#include "plumbline/feature/line_kind.hpp"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <memory>
#include <type_traits>

#include "catch.hpp"
#include "feature/recorded_rows.hpp"
#include "feature/residuals_of.hpp"
#include "feature/seen_lines.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;
using test::RecordedRows;
using test::SeenLines;

namespace {

template <class S>
using RgbdLines = SeenLines<S, Rig<Rgbd<Pinhole<S>, 64 * 64>>>;
template <class S>
using MonoLines = SeenLines<S, Rig<Mono<Pinhole<S>, 64 * 64>>>;

// Of a rig with a global shutter no derivatives.
static_assert(sizeof(MonoLines<double>::Kind::InWorld) < sizeof(RgbdLines<double>::Kind::InWorld));
static_assert(MonoLines<float>::Kind::rows_per_view == 2 && RgbdLines<float>::Kind::rows_per_view == 4);

template <class S>
constexpr double tolerance = std::is_same_v<S, float> ? 1e-3 : 1e-11;

double difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return (a - b).norm() / (1 + b.norm()); }

/// Lines some pixels off, seen by frame 3 from their anchors; every third one without depth.
template <class Lines>
struct Scene : Lines {
  using Kind = typename Lines::Kind;
  using S = typename Kind::Scalar;
  Scene() : Lines(9) {
    testing::Gaussian noise(11);
    for (std::size_t i = 0; i < 9; ++i) {
      auto& landmark = Lines::store->landmarks()[i];
      Vec<double, 4> error;
      error << 0.006 * noise.vector<3>(), 0.004 * noise();
      landmark.geometry.line = landmark.geometry.line.plus(Vec<S, 4>(error.template cast<S>()));
      if (i % 3 == 2) landmark.observations[3].clear_depth();
    }
  }
  RelativeView<S> view(int anchor, int target) const {
    return {Lines::window.T_world_body(anchor), Lines::window.T_world_body(target),
            Lines::T_body_cam.template cast<S>()};
  }
};

}  // namespace

TEMPLATE_TEST_CASE("line_kind: rows in the window are those of the residuals, whitened and weighted", "",
                   RgbdLines<float>, RgbdLines<double>, MonoLines<float>, MonoLines<double>) {
  using Kind = typename TestType::Kind;
  using S = typename Kind::Scalar;
  const Scene<TestType> scene;
  for (const auto& landmark : scene.store->landmarks()) {
    const auto view = scene.view(landmark.anchor, 3);
    const auto& seen = landmark.observations[3];
    RecordedRows<Kind> rows, expected;
    const double cost = Kind::add_view(scene.rig, typename Kind::Linearized(landmark.geometry), seen, view, 3, rows);
    double expected_cost = 0;
    test::for_each_view_residual(Kind{}, scene.rig, landmark.geometry, seen, view,
                                 [&](const auto& lin, const Mat<S, 2, 2>& L, const Huber<S>& loss) {
                                   REQUIRE(lin.valid);
                                   const Vec<S, 2> r = L * lin.r;
                                   const S w = std::sqrt(loss.weight(r.squaredNorm()));
                                   expected.template add<2>(3, Mat<S, 2, 6>(w * L * lin.J_r_target),
                                                            Mat<S, 2, 4>(w * L * lin.J_r_lambda), Vec<S, 2>(w * r));
                                   expected_cost += double(loss.rho(r.squaredNorm())) / 2;
                                 });
    REQUIRE(rows.rows() == (seen.has_depth() ? 4 : 2));
    REQUIRE(rows.rows() == expected.rows());
    REQUIRE(rows.slot == 3);
    REQUIRE(difference(rows.r, expected.r) < tolerance<S>);
    REQUIRE(difference(rows.J_target, expected.J_target) < tolerance<S>);
    REQUIRE(difference(rows.J_landmark, expected.J_landmark) < tolerance<S>);
    REQUIRE(cost == Approx(expected_cost).epsilon(tolerance<S>));
    REQUIRE(Kind::cost(scene.rig, typename Kind::InAnchor(landmark.geometry), seen, view) ==
            Approx(cost).epsilon(tolerance<S>));
  }
}

TEMPLATE_TEST_CASE("line_kind: rows of the anchor, and of the relation to others", "", RgbdLines<float>,
                   RgbdLines<double>, MonoLines<double>) {
  using Kind = typename TestType::Kind;
  using S = typename Kind::Scalar;
  const Scene<TestType> scene;
  for (const auto& landmark : scene.store->landmarks()) {
    const typename Kind::Linearized line(landmark.geometry);
    const auto& seen = landmark.seen_by_anchor();
    RecordedRows<Kind> rows, tie, damping;
    const double cost = Kind::add_anchor(line, seen, rows);
    const auto lin = AnchoredLineReprojection<S>{seen.pixels.measured}.linearize_in_anchor(landmark.geometry.line);
    REQUIRE(lin.valid);
    REQUIRE(rows.rows() == (seen.has_depth() ? 4 : 2));
    const Vec<S, 2> r = seen.pixels.L * lin.r;
    const S w = std::sqrt(Huber<S>{S(2.45)}.weight(r.squaredNorm()));
    const Eigen::MatrixXd J = (w * seen.pixels.L * lin.J_r_line).template cast<double>();
    REQUIRE(difference(rows.r.head(2), (w * r).template cast<double>()) < tolerance<S>);
    REQUIRE(difference(rows.J_landmark.topRows(2), J) < tolerance<S>);
    REQUIRE(rows.J_target.isZero(0));
    REQUIRE(Kind::cost_in_anchor(typename Kind::InAnchor(landmark.geometry), seen) ==
            Approx(cost).epsilon(tolerance<S>));

    Kind::add_anchor_pixels(line, seen, tie);  // the pixels alone
    REQUIRE(tie.rows() == 2);
    REQUIRE(difference(tie.J_landmark, J) < tolerance<S>);
    Kind::add_damping(damping);  // sigma = 1 on each angle
    REQUIRE(damping.rows() == Kind::damping_rows);
    REQUIRE(damping.J_landmark.isIdentity(0));
    REQUIRE(damping.r.isZero(0));
  }
}

TEMPLATE_TEST_CASE("line_kind: what does not fit is dropped, and depth by itself", "", RgbdLines<float>,
                   RgbdLines<double>) {
  using Kind = typename TestType::Kind;
  using S = typename Kind::Scalar;
  TestType scene(1, 0);
  const auto& landmark = scene.store->landmarks()[0];
  const typename Kind::InAnchor line(landmark.geometry);
  const RelativeView<S> view(scene.window.T_world_body(0), scene.window.T_world_body(3),
                             scene.T_body_cam.template cast<S>());
  const auto original = landmark.observations[3];
  auto seen = original;
  Kind::reject_outliers(scene.rig, line, seen, view);
  REQUIRE((seen.valid && seen.has_depth()));
  auto depth = original.depth.get();
  depth.measured.inverse_depth_measured[1] += S(0.2);
  seen.depth.set(depth);
  Kind::reject_outliers(scene.rig, line, seen, view);
  REQUIRE((seen.valid && !seen.has_depth()));
  seen = original;
  seen.pixels.measured.bearing_end = (seen.pixels.measured.bearing_end + Vec<S, 3>(S(0.1), S(-0.1), 0)).normalized();
  Kind::reject_outliers(scene.rig, line, seen, view);
  REQUIRE_FALSE(seen.valid);

  seen = landmark.seen_by_anchor();  // the anchor's own pixels stay
  seen.pixels.measured.bearing_end = (seen.pixels.measured.bearing_end + Vec<S, 3>(S(0.1), S(-0.1), 0)).normalized();
  Kind::reject_outliers_in_anchor(line, seen);
  REQUIRE(seen.valid);
  depth = landmark.seen_by_anchor().depth.get();
  depth.measured.inverse_depth_measured[1] += S(0.2);
  seen.depth.set(depth);
  Kind::reject_outliers_in_anchor(line, seen);
  REQUIRE_FALSE(seen.has_depth());
}

TEMPLATE_TEST_CASE("line_kind: what no frame can see has a cost and no rows", "", RgbdLines<float>, MonoLines<double>) {
  using Kind = typename TestType::Kind;
  using S = typename Kind::Scalar;
  TestType scene(1, 0);
  auto& landmark = scene.store->landmarks()[0];
  auto seen = landmark.observations[3];
  seen.pixels.measured.bearing_start *= S(-1);
  seen.pixels.measured.bearing_end *= S(-1);
  const RelativeView<S> view(scene.window.T_world_body(0), scene.window.T_world_body(3),
                             scene.T_body_cam.template cast<S>());
  RecordedRows<Kind> rows;
  const typename Kind::Linearized line(landmark.geometry);
  REQUIRE(Kind::add_view(scene.rig, line, seen, view, 3, rows) > 50);
  REQUIRE(rows.rows() == 0);
  REQUIRE(Kind::add_anchor(line, seen, rows) > 50);
  REQUIRE(rows.rows() == 0);
  Kind::reject_outliers(scene.rig, typename Kind::InAnchor(landmark.geometry), seen, view);
  REQUIRE_FALSE(seen.valid);
}

TEMPLATE_TEST_CASE("line_kind: rows in one frame are those of the residuals, widened by the landmark's covariance", "",
                   RgbdLines<float>, RgbdLines<double>, MonoLines<float>, MonoLines<double>) {
  using Kind = typename TestType::Kind;
  using S = typename Kind::Scalar;
  Scene<TestType> scene;
  const double scale = GENERATE(0.0, 1e-7, 1e-5);
  for (auto& landmark : scene.store->landmarks()) {
    Mat<double, 4, 4> A;
    A << 3, 0, 0, 0, 1, 2, 0, 0, -1, 1, 3, 0, 1, -1, 2, 4;
    landmark.geometry.covariance = (scale * A * A.transpose()).template cast<S>();
    const auto& seen = landmark.observations[3];
    const SE3<S> T_world_anchor = scene.window.T_world_body(landmark.anchor) * scene.T_body_cam.template cast<S>();
    const BodyView<S> body(scene.window.T_world_body(3), scene.T_body_cam.template cast<S>());
    const auto in_world = Kind::in_world(landmark.geometry, seen, T_world_anchor);
    REQUIRE(Kind::has_depth(in_world) == seen.has_depth());
    const Mat<double, 6, 4> M =
        (plucker_transform(T_world_anchor) * landmark.geometry.line.plucker_jacobian()).template cast<double>();
    bool depth = false;
    test::for_each_world_residual(
        Kind{}, scene.rig, landmark.geometry, seen, T_world_anchor, body,
        [&](const auto& lin, const Mat<S, 2, 2>& L, const Huber<S>&) {
          const auto rows = depth ? Kind::depth_rows(body, in_world) : Kind::pixel_rows(scene.rig, body, in_world);
          REQUIRE(rows.valid);
          const Mat<double, 2, 2> L_d = L.template cast<double>();
          const Mat<double, 2, 4> J_l = lin.J_r_line.template cast<double>() * M;
          const Mat<double, 2, 2> covariance =
              (L_d.transpose() * L_d).inverse() +
              J_l * landmark.geometry.covariance.template cast<double>() * J_l.transpose();  // (29)
          const Mat<double, 2, 2> information = covariance.inverse();
          const Mat<double, 2, 6> J = lin.J_r_pose.template cast<double>();
          const Mat<double, 2, 6> found = rows.J.template leftCols<6>().template cast<double>();
          const Vec<double, 2> e = rows.r.template cast<double>(), r = lin.r.template cast<double>();
          REQUIRE(difference(found.transpose() * found, J.transpose() * information * J) < 20 * tolerance<S>);
          REQUIRE(difference(found.transpose() * e, J.transpose() * information * r) < 20 * tolerance<S>);
          if (!depth) REQUIRE(Kind::error_px(scene.rig, body, in_world) == Approx(r.norm() / std::sqrt(2.0)));
          depth = true;
        });
  }
}

TEMPLATE_TEST_CASE("line_kind: what becomes of a landmark after an optimization", "", float, double) {
  using S = TestType;
  using Kind = typename RgbdLines<S>::Kind;
  const RgbdLines<S> scene(1);
  auto geometry = scene.store->landmarks()[0].geometry;
  const auto& seen = scene.store->landmarks()[0].seen_by_anchor();
  const Mat<S, 4, 4> covariance = S(1e-5) * Mat<S, 4, 4>::Identity(), unknown = S(10) * Mat<S, 4, 4>::Identity();
  REQUIRE(Kind::set_covariance(geometry, seen, &covariance));
  REQUIRE(geometry.covariance == covariance);
  REQUIRE_FALSE(Kind::set_covariance(geometry, seen, nullptr));
  REQUIRE_FALSE(Kind::set_covariance(geometry, seen, &unknown));  // its distance is unknown
}

TEST_CASE("line_kind: geometry") {
  using Kind = RgbdLines<double>::Kind;
  const RgbdLines<double> scene(3);
  for (std::size_t i = 0; i < 3; ++i) {
    auto line = scene.store->landmarks()[i].geometry;
    const auto& seen = scene.store->landmarks()[i].seen_by_anchor();
    REQUIRE((Kind::middle(line) - line.middle()).norm() == 0);
    REQUIRE(Kind::inverse_range(line) == Approx(1 / line.middle().norm()));
    const Vec<double, 4> d(0.01, -0.02, 0.03, 0.01);
    auto moved = line;
    Kind::step(moved, d);
    REQUIRE((minus(moved.line, line.line) - d).norm() < 1e-12);
    auto rescaled = line;
    Kind::rescale(rescaled, 2);
    REQUIRE((Kind::middle(rescaled) - 2 * Kind::middle(line)).norm() < 1e-9);

    auto turned = line;
    Kind::change_readout(turned, seen, 0.01);
    REQUIRE(minus(turned.line, line.line).norm() > 1e-4);
    auto unseen = seen;
    unseen.valid = false;
    turned = line;
    Kind::change_readout(turned, unseen, 0.01);  // by no derivative
    REQUIRE(minus(turned.line, line.line).norm() < 1e-12);
  }
}

TEST_CASE("line_kind: motion is across the edge, made up for what cannot be seen along it") {
  using Observation = RgbdLines<double>::Observation;
  Observation then, now;
  then.segment = {Vec<float, 2>(0, 0), Vec<float, 2>(100, 0), 10};
  double sum = 0;
  constexpr int directions = 360;
  for (int k = 0; k < directions; ++k) {
    const float a = 6.2831853f * (float(k) + 0.5f) / directions;
    const Vec<float, 2> shift(3 * std::cos(a), 3 * std::sin(a));
    now.segment = {then.segment.start + shift, then.segment.end + shift, 10};
    sum += RgbdLines<double>::Kind::motion_px(then, now) / directions;
  }
  REQUIRE(sum == Approx(3).epsilon(1e-3));
}
