// What a prior keeps of the frames that leave, against dense least squares in which they are eliminated.
//                                                                                          docs/math/window.md
#include "plumbline/backend/window_prior.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "catch.hpp"
#include "plumbline/solver/landmark_elimination.hpp"
#include "plumbline/state/frame_window.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

constexpr int slots = 4, max_rows = 12, max_columns = 4;
constexpr int pose_dim = state::Pose::dim;

template <class S, class Layout>
struct Scene {
  static constexpr int frame_dim = Layout::dim, at_extrinsics = slots * frame_dim,
                       extrinsics_dim = state::Extrinsics::dim;
  static constexpr int at_time_offset = at_extrinsics + extrinsics_dim, dim = at_extrinsics + RigLayout<Layout>::dim;
  using Window = FrameWindow<S, Layout, slots>;
  using Prior = WindowPrior<Window, max_rows, max_columns>;
  using Equations = NormalEquations<double, frame_dim, slots + (has_extrinsics<Layout> ? 1 : 0)>;
  using Pairs = RelativeEquations<double, pose_dim, slots>;
  using Dense = Eigen::MatrixXd;
  using DenseVector = Eigen::VectorXd;

  testing::Gaussian noise;
  Window window;
  Prior prior;
  Pairs pairs;
  Dense A = Dense::Zero(0, dim);  ///< all rows that were added, by the corrections of all frames
  DenseVector b = DenseVector::Zero(0);

  explicit Scene(std::uint64_t seed) : noise(seed) {
    for (int a = 0; a < slots; ++a) {
      for (int j = 0; j < slots; ++j) pairs.set_transport(a, j, random<double, pose_dim, pose_dim>());
    }
    if constexpr (has_extrinsics<Layout>) {
      window.estimate_extrinsics(
          SE3<S>(SO3<S>::exp(noise.vector<3>().template cast<S>()), noise.vector<3>().template cast<S>()));
      window.estimate_time_offset(0.02);
    }
  }

  /// Numbers that are the same in float and double.
  template <class T, int Rows, int Columns>
  Mat<T, Rows, Columns> random() {
    Mat<T, Rows, Columns> out;
    for (int c = 0; c < Columns; ++c) {
      for (int k = 0; k < Rows; ++k) out(k, c) = T(std::round(1024 * noise()) / 1024);
    }
    return out;
  }
  void insert(TimeNs t_ns) {
    typename Window::Value x;
    x.T_world_body = SE3<S>(SO3<S>::exp(noise.vector<3>().template cast<S>()), noise.vector<3>().template cast<S>());
    window.insert(t_ns, x);
  }
  /// Moves every frame.
  void move(double size) { window.move(Vec<double, dim>(size * noise.vector<dim>())); }
  DenseVector corrections() const {
    DenseVector e = DenseVector::Zero(dim);
    for (int k = 0; k < slots; ++k) {
      if (window[k].used) {
        e.segment<frame_dim>(k * frame_dim) = window[k].state.correction().template cast<double>();
      }
    }
    if constexpr (has_extrinsics<Layout>) {
      e.segment<extrinsics_dim>(at_extrinsics) = window.extrinsics().correction().template cast<double>();
      e[at_time_offset] = window.time_offset().correction()[0];
    }
    return e;
  }

  void append(const Dense& J, const DenseVector& r) {
    Dense A_new(A.rows() + J.rows(), dim);
    DenseVector b_new(A_new.rows());
    A_new << A, J;
    b_new << b, r;
    A = A_new;
    b = b_new;
  }
  template <int Rows>
  void set(int slot) {
    const Mat<double, Rows, frame_dim> J = random<double, Rows, frame_dim>();
    prior.set(window, slot, J);
    A = Dense::Zero(Rows, dim);
    A.middleCols<frame_dim>(slot * frame_dim) = J;
    b = DenseVector::Zero(Rows);
  }
  /// Rows at the current state, of a factor.
  template <int Rows>
  void add_factor(int i, int j) {
    const Mat<S, Rows, frame_dim> J_i = random<S, Rows, frame_dim>(), J_j = random<S, Rows, frame_dim>();
    const Vec<S, Rows> J_offset = random<S, Rows, 1>(), r = random<S, Rows, 1>();
    prior.add_factor(i, J_i, j, J_j, J_offset, r);
    Dense J = Dense::Zero(Rows, dim);
    J.middleCols<frame_dim>(i * frame_dim) = J_i.template cast<double>();
    J.middleCols<frame_dim>(j * frame_dim) = J_j.template cast<double>();
    if constexpr (has_time_offset<Layout>) J.col(at_time_offset) = J_offset.template cast<double>();
    append(J, r.template cast<double>() - J * corrections());
  }
  /// Rows at the current state, of a landmark that `anchor` holds and all others see.
  template <int Columns>
  void add_landmark(int anchor) {
    LandmarkElimination<S, Columns, pose_dim, slots, max_rows> landmark;
    landmark.reset(anchor);
    Dense J = Dense::Zero(0, dim), J_l = Dense::Zero(0, Columns);
    DenseVector r = DenseVector::Zero(0);
    for (int k = 0; k < slots; ++k) {
      if (!window[k].used || k == anchor) continue;
      const Mat<S, 3, pose_dim> J_p = random<S, 3, pose_dim>();
      const Mat<S, 3, Columns> J_k = random<S, 3, Columns>();
      const Vec<S, 3> r_k = random<S, 3, 1>();
      REQUIRE(landmark.template add<3>(k, J_p, J_k, r_k));
      const int n = int(J.rows());
      J.conservativeResize(n + 3, dim);
      J.bottomRows<3>().setZero();
      J.block<3, pose_dim>(n, k * frame_dim) = J_p.template cast<double>();
      J.block<3, pose_dim>(n, anchor * frame_dim) = -J_p.template cast<double>() * pairs.transport(anchor, k);
      J_l.conservativeResize(n + 3, Columns);
      J_l.bottomRows<3>() = J_k.template cast<double>();
      r.conservativeResize(n + 3);
      r.tail<3>() = r_k.template cast<double>();
    }
    if constexpr (has_extrinsics<Layout>) {
      Dense together = Dense::Zero(J.rows(), pose_dim);
      for (int k = 0; k < slots; ++k) together += J.middleCols<pose_dim>(k * frame_dim);
      J.middleCols<extrinsics_dim>(at_extrinsics) =
          together * window.extrinsics().first_estimate().template cast<double>().adjoint();
    }
    prior.add_landmark(landmark, pairs, NoReadoutDerivatives{});
    const Dense Q = orthogonal_to(J_l);
    append(Q * J, Q * (r - J * corrections()));
  }
  void retire(int slot) {
    prior.retire(window, slot);
    const Dense Q = orthogonal_to(A.middleCols<frame_dim>(slot * frame_dim));
    A = Q * A;
    A.middleCols<frame_dim>(slot * frame_dim).setZero();
    b = Q * b;
  }
  /// The projection that takes out what M can explain.
  static Dense orthogonal_to(const Dense& M) {
    const Eigen::ColPivHouseholderQR<Dense> qr(M);
    const Dense Q = Dense(qr.householderQ()).leftCols(qr.rank());
    return Dense::Identity(M.rows(), M.rows()) - Q * Q.transpose();
  }

  double cost() const { return (A * corrections() + b).squaredNorm() / 2; }
  /// The prior and the dense rows are the same function of the corrections, up to a constant.
  void require_same() {
    Equations equations;
    equations.reset(Equations::max_blocks);
    prior.add_to(window, equations);
    const Dense H = A.transpose() * A;
    const DenseVector g = A.transpose() * (A * corrections() + b);
    double error = 0;
    for (int c = 0; c < dim; ++c) {
      for (int r = c; r < dim; ++r) error = std::max(error, std::abs(equations.H()(r, c) - H(r, c)));
    }
    CHECK(error < 1e-9 * (1 + H.norm()));
    CHECK((equations.b() - g).norm() < 1e-9 * (1 + g.norm()));
    const Window kept = window;
    const double begin = prior.cost(window), expected = cost();
    for (int n = 0; n < 5; ++n) {
      move(0.1);
      CHECK(prior.cost(window) - begin == Approx(cost() - expected).epsilon(1e-9).margin(1e-9));
    }
    window = kept;
  }
};

using Cases = std::tuple<Scene<float, VisualLayout>, Scene<double, VisualLayout>, Scene<float, InertialLayout>,
                         Scene<double, InertialLayout>>;

}  // namespace

TEMPLATE_LIST_TEST_CASE("window_prior: rows on one frame, from where it is", "", Cases) {
  TestType scene(1);
  scene.insert(0);
  scene.insert(1);
  scene.move(0.3);
  scene.template set<5>(1);
  CHECK(scene.prior.cost(scene.window) < 1e-11);
  scene.require_same();
  scene.move(0.2);
  CHECK(scene.prior.cost(scene.window) == Approx(scene.cost()));
  CHECK(scene.cost() > 0);
  // Again: the previous prior is replaced.
  scene.template set<4>(0);
  scene.require_same();
}

TEMPLATE_LIST_TEST_CASE("window_prior: a frame with its factors and landmarks becomes rows on those that stay", "",
                        Cases) {
  TestType scene(2);
  for (int k = 0; k < slots; ++k) {
    scene.insert(k);
    if (k == 0) scene.template set<6>(0);
    scene.move(0.1);
  }
  scene.require_same();
  for (int leaving = 0; leaving < 3; ++leaving) {
    scene.prior.begin_retirement(scene.window);
    scene.template add_factor<15>(leaving, leaving + 1);
    for (int n = 0; n < 4; ++n) scene.template add_landmark<1>(leaving);
    if (leaving < 2) scene.template add_landmark<4>(leaving);
    scene.retire(leaving);
    CHECK_FALSE(scene.window[leaving].used);
    scene.require_same();
    scene.move(0.1);
    scene.require_same();
  }
}

TEMPLATE_LIST_TEST_CASE("window_prior: one more row on two frames, whatever its residual", "", Cases) {
  constexpr int frame_dim = TestType::frame_dim;
  TestType scene(6);
  for (int k = 0; k < slots; ++k) {
    scene.insert(k);
    if (k == 0) scene.template set<6>(0);
    scene.move(0.1);
  }
  for (const int other : {2, 3}) {
    const double r = other == 2 ? 0 : 1.5;
    const Mat<double, 1, frame_dim> J_i = scene.template random<double, 1, frame_dim>(),
                                    J_j = scene.template random<double, 1, frame_dim>();
    typename TestType::Dense J = TestType::Dense::Zero(1, TestType::dim);
    J.template middleCols<frame_dim>(0) = J_i;
    J.template middleCols<frame_dim>(other * frame_dim) = J_j;
    const double before = scene.prior.cost(scene.window);
    scene.prior.add(scene.window, 0, J_i, other, J_j, r);
    scene.append(J, Vec<double, 1>(r) - J * scene.corrections());
    CHECK(scene.prior.cost(scene.window) == Approx(before + r * r / 2));
    scene.require_same();
    scene.move(0.1);
    scene.require_same();
  }
  scene.prior.begin_retirement(scene.window);
  scene.template add_factor<15>(0, 1);
  scene.retire(0);
  scene.require_same();
}

TEMPLATE_LIST_TEST_CASE("window_prior: a freed slot is used again, by a frame without a prior", "", Cases) {
  TestType scene(3);
  for (int k = 0; k < slots; ++k) scene.insert(k);
  scene.template set<6>(1);
  scene.prior.begin_retirement(scene.window);
  scene.template add_landmark<1>(1);
  scene.retire(1);
  scene.insert(9);
  REQUIRE(scene.window.newest() == 1);
  scene.require_same();
}

TEMPLATE_LIST_TEST_CASE("window_prior: only frames with a prior keep their first estimate", "", Cases) {
  TestType scene(4);
  for (int k = 0; k < slots; ++k) scene.insert(k);
  scene.template set<6>(0);
  scene.prior.begin_retirement(scene.window);
  scene.template add_factor<15>(0, 1);
  scene.retire(0);
  const auto first = [&](int k) { return scene.window[k].state.first_estimate().T_world_body; };
  const auto known = first(1), unknown = first(2);
  scene.move(0.1);
  CHECK(minus(first(1), known).norm() == 0);
  CHECK(minus(first(2), unknown).norm() > 1e-3);
}

TEMPLATE_LIST_TEST_CASE("window_prior: rows that are no numbers are lost, and with them the frame that leaves alone",
                        "", Cases) {
  using S = typename TestType::Window::Scalar;
  constexpr int frame_dim = TestType::frame_dim;
  TestType scene(5);
  for (int k = 0; k < slots; ++k) scene.insert(k);
  scene.template set<6>(0);
  scene.prior.begin_retirement(scene.window);
  scene.template add_factor<15>(0, 1);
  scene.retire(0);
  scene.prior.begin_retirement(scene.window);
  Mat<S, 2, frame_dim> J;
  J.setConstant(std::numeric_limits<S>::quiet_NaN());
  const auto A = scene.A;
  scene.prior.add_factor(2, J, 3, J, Vec<S, 2>(Vec<S, 2>::Zero()), Vec<S, 2>(Vec<S, 2>::Zero()));
  scene.retire(2);
  scene.A = A;  // frame 2 was unknown before: all stays as it is
  scene.require_same();
}

namespace {

/// Two frames of a shutter that rolls, and a prior on the readout time of 0.01 s with a sigma of 0.02 s.
struct RollingScene : Scene<double, VisualLayout> {
  using Rolling = WindowPrior<Window, max_rows, max_columns, true>;
  static constexpr double value = 0.01, sigma = 0.02;
  Rolling rolling;

  RollingScene() : Scene<double, VisualLayout>(5) {
    insert(0);
    insert(1);
    insert(2);
    rolling.set_readout_prior(value, sigma);
    rolling.set(window, 0, random<double, 6, 6>());
  }
  struct Derivatives {
    Vec<double, max_rows> values;
    double operator[](int k) const { return values[k]; }
  };
  /// All landmarks of frame 0 leave with it.
  void retire_first(int count, double walk_s) {
    rolling.begin_retirement(window);
    for (int n = 0; n < count; ++n) {
      LandmarkElimination<double, 1, pose_dim, slots, max_rows> landmark;
      landmark.reset(0);
      for (const int k : {1, 2})
        landmark.add<3>(k, random<double, 3, pose_dim>(), random<double, 3, 1>(), random<double, 3, 1>());
      rolling.add_landmark(landmark, pairs, Derivatives{100 * random<double, max_rows, 1>()});
    }
    rolling.retire(window, 0, walk_s);
  }
  /// Information on the readout and its gradient, the frames being estimated with it.
  ReadoutBorder reduced() const {
    Equations equations;
    equations.reset(Equations::max_blocks);
    rolling.add_to(window, equations);
    Eigen::VectorXd column = Eigen::VectorXd::Zero(dim);
    ReadoutBorder border;
    rolling.add_readout_to(window, column, border);
    const Dense H = Dense(equations.H().template selfadjointView<Eigen::Lower>());
    const Eigen::VectorXd x = H.completeOrthogonalDecomposition().solve(column);
    return {border.information - column.dot(x), border.gradient - x.dot(equations.b())};
  }
};

}  // namespace

TEST_CASE("window_prior: the prior of the readout time, and the cost of a change") {
  RollingScene scene;
  CHECK(scene.reduced().information == Approx(1 / (scene.sigma * scene.sigma)));
  CHECK(scene.reduced().gradient == Approx(-scene.value / (scene.sigma * scene.sigma)));
  scene.rolling.set_readout(0.03);
  CHECK(scene.reduced().gradient == Approx((0.03 - scene.value) / (scene.sigma * scene.sigma)));
  CHECK(scene.rolling.cost(scene.window) == Approx(0.5));
}

TEST_CASE("window_prior: marginalized landmarks leave their information about the readout time") {
  RollingScene scene, walked;
  scene.retire_first(12, 0);
  walked.retire_first(12, 0.01);
  const ReadoutBorder after = scene.reduced(), inflated = walked.reduced();
  CHECK(after.information > 2 / (scene.sigma * scene.sigma));
  // The estimate is the same, its variance has grown.
  CHECK(inflated.gradient / inflated.information == Approx(after.gradient / after.information));
  CHECK(1 / inflated.information == Approx(1 / after.information + 0.01 * 0.01));
  // A change of the readout is a change of the residuals.
  const double before = scene.rolling.cost(scene.window);
  scene.rolling.set_readout(1e-3);
  const ReadoutBorder moved = scene.reduced();
  CHECK(moved.information == Approx(after.information));
  CHECK(moved.gradient == Approx(after.gradient + 1e-3 * after.information));
  CHECK(scene.rolling.cost(scene.window) != Approx(before));
}
