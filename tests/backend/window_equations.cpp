// Where the camera sits, against differences and a dense change of variables.                 docs/math/window.md (6)
#include "plumbline/backend/window_equations.hpp"

#include <Eigen/Core>
#include <memory>

#include "catch.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/residual/relative_view.hpp"
#include "plumbline/state/frame_window.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

template <class S>
SE3<S> random_pose(testing::Gaussian& noise, double size) {
  return {SO3<S>::exp((size * noise.vector<3>()).template cast<S>()), (size * noise.vector<3>()).template cast<S>()};
}

}  // namespace

TEMPLATE_TEST_CASE("window_equations: a step of the extrinsics is its adjoint's step of all bodies", "", float,
                   double) {
  using S = TestType;
  const S step = std::is_same_v<S, float> ? S(1e-3) : S(1e-5), tolerance = 20 * step * step + S(1e-6) * step;
  testing::Gaussian noise(3);
  for (int n = 0; n < 200; ++n) {
    // Also bodies in one place, cameras in the body's middle and far from it.
    const double apart = n % 4 == 0 ? 0 : 1, lever = n % 5 == 0 ? 0 : n % 5 == 1 ? 3 : 0.2;
    const SE3<S> T_anchor = random_pose<S>(noise, 1), T_target = T_anchor * random_pose<S>(noise, apart);
    const SE3<S> T_body_cam(random_pose<S>(noise, 1).rotation(), (lever * noise.vector<3>()).template cast<S>());
    const Vec<S, 6> e = step * noise.vector<6>().normalized().template cast<S>(), d = T_body_cam.adjoint() * e;
    const RelativeView<S> by_extrinsics(T_anchor, T_target, plus(T_body_cam, e));
    const RelativeView<S> by_bodies(plus(T_anchor, d), plus(T_target, d), T_body_cam);
    const S size = 1 + by_extrinsics.t_target_anchor().norm() + S(lever * lever);
    CHECK((by_extrinsics.R_target_anchor() - by_bodies.R_target_anchor()).norm() < tolerance);
    CHECK((by_extrinsics.t_target_anchor() - by_bodies.t_target_anchor()).norm() < tolerance * size);
  }
}

TEST_CASE("window_equations: the change of variables by the extrinsics holds for any observation") {
  constexpr int slots = 4, frame_dim = InertialLayout::dim, pose_dim = state::Pose::dim;
  using Window = FrameWindow<double, InertialLayout, slots>;
  using Equations = WindowEquations<Window>;
  using Dense = Eigen::MatrixXd;
  testing::Gaussian noise(5);
  Window window;
  window.estimate_extrinsics(random_pose<double>(noise, 1));
  const auto equations = std::make_unique<Equations>();

  equations->begin();
  const int dim = equations->normal.dim(), at_extrinsics = slots * frame_dim;
  REQUIRE(dim == at_extrinsics + frame_dim);
  Dense H = Dense::Zero(dim, dim), transform = Dense::Identity(dim, dim);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(dim);
  for (int i = 0; i < slots; ++i) {
    const Vec<double, pose_dim> g = noise.vector<pose_dim>();
    equations->normal.add_gradient(i, g);
    b.segment<pose_dim>(i * frame_dim) = g;
    for (int j = 0; j <= i; ++j) {
      Mat<double, pose_dim, pose_dim> B;
      for (int c = 0; c < pose_dim; ++c) B.col(c) = noise.vector<pose_dim>();
      if (i == j) B = Mat<double, pose_dim, pose_dim>(B + B.transpose());
      equations->normal.add_block(i, j, B);
      H.block<pose_dim, pose_dim>(i * frame_dim, j * frame_dim) = B;
      H.block<pose_dim, pose_dim>(j * frame_dim, i * frame_dim) = B.transpose();
    }
    transform.block<pose_dim, pose_dim>(i * frame_dim, at_extrinsics) = window.extrinsics().first_estimate().adjoint();
  }
  transform.rightCols<frame_dim>().rightCols(frame_dim - pose_dim).setZero();
  transform.block(at_extrinsics, at_extrinsics, frame_dim, frame_dim).setZero();

  ExtrinsicsOptions nothing;
  nothing.rotation_sigma = nothing.position_sigma = 1e12;
  equations->add_extrinsics(window);
  equations->add_extrinsics(window, ExtrinsicsPrior(nothing));
  const Dense expected = transform.transpose() * H * transform;
  double error = 0;
  for (int c = 0; c < dim; ++c) {
    for (int r = c; r < dim; ++r) error = std::max(error, std::abs(equations->normal.H()(r, c) - expected(r, c)));
  }
  CHECK(error < 1e-9 * expected.norm());
  CHECK((equations->normal.b() - transform.transpose() * b).norm() < 1e-9 * b.norm());
}

TEST_CASE("window_equations: without extrinsics nothing is changed") {
  FrameWindow<double, InertialLayout, 3> window;
  const auto equations = std::make_unique<WindowEquations<decltype(window)>>();
  equations->begin();
  equations->add_extrinsics(window, ExtrinsicsPrior({}));
  REQUIRE(equations->normal.H().norm() == 0);
  STATIC_REQUIRE(WindowEquations<FrameWindow<double, VisualLayout, 3>>::Normal::max_dim == 3 * state::Pose::dim);
}

namespace {

/// Two rows on two frames and the time offset.
struct TwoRows {
  static constexpr int frame_dim = InertialLayout::dim;
  Mat<float, 2, frame_dim> J_i, J_j;
  Vec<float, 2> J_offset, r;

  explicit TwoRows(testing::Gaussian& noise) {
    for (int c = 0; c < frame_dim; ++c) {
      J_i.col(c) = noise.vector<2>().cast<float>();
      J_j.col(c) = noise.vector<2>().cast<float>();
    }
    J_offset = noise.vector<2>().cast<float>();
    r = noise.vector<2>().cast<float>();
  }
  static bool active() { return true; }
  void for_each_row(const auto&, int, auto&& take) const { take(2, J_i, 0, J_j, J_offset, r); }
};
struct KnowsNothing {
  void add_to(const auto&, auto&) const {}
};

}  // namespace

TEST_CASE("window_equations: the time offset is in factors and its prior, or fixed") {
  constexpr int slots = 3, frame_dim = InertialLayout::dim, offset = slots * frame_dim + state::Extrinsics::dim;
  testing::Gaussian noise(7);
  const TwoRows rows(noise);
  for (const bool estimated : {true, false}) {
    FrameWindow<double, InertialLayout, slots> window;
    for (int k = 0; k < slots; ++k) window.insert(k, {});
    window.estimate_extrinsics({});
    if (estimated) window.estimate_time_offset(0.01);
    Vec<double, slots* frame_dim + 7> step = Vec<double, slots * frame_dim + 7>::Zero();
    step[offset] = 2e-3;
    window.move(step);
    const auto equations = std::make_unique<WindowEquations<decltype(window)>>();
    equations->begin();
    const TimeOffsetPrior prior({}, 0);
    equations->add_time_offset(window, prior);
    equations->add_priors_and_factors(window, KnowsNothing{}, rows);
    const auto& H = equations->normal.H();
    const auto& b = equations->normal.b();
    CAPTURE(estimated);
    if (!estimated) {
      CHECK(H(offset, offset) == 1);
      CHECK(H.row(offset).head(offset).norm() == 0);
      CHECK(b[offset] == 0);
      continue;
    }
    const Vec<double, 2> J = rows.J_offset.cast<double>();
    CHECK(H(offset, offset) == Approx(J.squaredNorm() + prior.information(2e-3)));
    CHECK(b[offset] == Approx(J.dot(rows.r.cast<double>()) + 2e-3 * prior.information(2e-3)));
    for (int c = 0; c < frame_dim; ++c) {
      CHECK(H(offset, 2 * frame_dim + c) == Approx(J.dot(rows.J_i.col(c).cast<double>())));
      CHECK(H(offset, c) == Approx(J.dot(rows.J_j.col(c).cast<double>())));
      CHECK(H(offset, frame_dim + c) == 0);
    }
  }
}
