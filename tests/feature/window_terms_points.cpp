// What points add to a window against dense references built from the residual headers alone, in double.

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <memory>
#include <type_traits>
#include <vector>

#include "catch.hpp"
#include "plumbline/feature/landmark_store.hpp"
#include "plumbline/feature/point_kind.hpp"
#include "plumbline/feature/window_terms.hpp"
#include "plumbline/residual/inverse_depth_point.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/solver/bounded_matrix.hpp"
#include "plumbline/solver/normal_equations.hpp"
#include "plumbline/state/frame_window.hpp"
#include "plumbline/testing/simulated_points.hpp"

using namespace plumbline;

namespace {

constexpr int slots = 5, used = 4, pose_dim = 6 * slots;
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Rows [J over all poses, by slot | J of lambda | r] of one landmark, whitened and weighted, and what they cost.
struct DenseRows {
  Eigen::MatrixXd J_p, J_l;
  Eigen::VectorXd r;
  double cost = 0;

  template <int R>
  void add(const AnchoredLinearization<double, R>& lin, const Mat<double, R, R>& L, const Huber<double>& loss,
           int anchor, int target) {
    const Vec<double, R> whitened = L * lin.r;
    const double s = whitened.squaredNorm(), w = std::sqrt(loss.weight(s));
    const Eigen::Index n = r.size();
    J_p.conservativeResize(n + R, pose_dim);
    J_l.conservativeResize(n + R, 1);
    r.conservativeResize(n + R);
    J_p.bottomRows(R).setZero();
    if (anchor >= 0) {
      J_p.block(n, 6 * anchor, R, 6) = w * L * lin.J_r_anchor;
      J_p.block(n, 6 * target, R, 6) = w * L * lin.J_r_target;
    }
    J_l.bottomRows(R) = w * L * lin.J_r_lambda;
    r.tail(R) = w * whitened;
    cost += loss.rho(s) / 2;
  }
  double information() const { return J_l.squaredNorm(); }
};

template <class S>
struct Scene {
  using Sensors = Rig<Rgbd<Pinhole<S>>>;
  using Kind = PointKind<Sensors>;
  using Store = LandmarkStore<Kind, 24, slots>;
  using Landmark = typename Store::Landmark;
  using Terms = WindowTerms<Store>;
  using Equations = NormalEquations<double, 6, slots>;

  testing::SimulatedPoints points;
  SE3<double> T_body_cam{SO3<double>::exp({0.1, -0.2, 0.3}), Vec<double, 3>(0.05, -0.1, 0.02)};
  Sensors rig{};
  Store store{{}};
  FrameWindow<S, VisualLayout, slots> window;
  WindowViews<S, slots> views;
  typename Terms::Pairs pairs;
  std::unique_ptr<Terms> terms = std::make_unique<Terms>();

  /// Four keyframes off their true poses, two of them with fixed linearization points, and all kinds of landmarks.
  Scene() {
    rig.vision.camera = {S(460), S(460), S(319.5), S(239.5), {}};
    points.scatter(16, {1.0, 0.7, 1.0}, 5);
    testing::Gaussian noise(7);
    for (int k = 0; k < used; ++k) {
      const SE3<double> T(SO3<double>::exp({0.02 * k, -0.05 * k, 0.03 * k}), Vec<double, 3>(0.15 * k, 0.05 * k, -3));
      Vec<double, 6> error;
      error << 0.004 * noise.vector<3>(), 0.006 * noise.vector<3>();
      window.insert(k, {plus(T, error).template cast<S>()});
      if (k < 2) {
        window.state(k).fix_first_estimates();
        window.state(k).add((0.5 * error).cast<S>());
      }
      points.observe(store, T * T_body_cam, k, noise);
      if (k == 0) points.scatter(6, {1.0, 0.7, 1.0}, 8);  // seen from the second keyframe on
    }
    for (Landmark& landmark : store.landmarks()) {
      landmark.geometry.inverse_range *= S(1 + 0.02 * noise());
      landmark.solved = true;
    }
    store.landmarks()[0].observations[0].depth.set({});  // no depth in the anchor
    store.landmarks()[1].observations[2].depth.set({});  // nor elsewhere
    store.landmarks()[2].observations[3].uv.x() += 30;   // beyond the kernel's threshold
    InverseDepth<S> twice = store.landmarks()[3].observations[1].depth.get();
    twice.value *= 2;
    store.landmarks()[3].observations[1].depth.set(twice);
    store.landmarks()[4].observations[1].L << 2.0f, 0.7f, 0.0f, 0.3f;
    store.landmarks()[5].located = false;
    for (int k = 1; k < used; ++k) store.landmarks()[6].observations[std::size_t(k)].valid = false;
    linearize_views();
  }
  void linearize_views() {
    views.update(window, T_body_cam.template cast<S>());
    views.set_transports(window, pairs);
  }
  double linearize() {
    pairs.reset();
    return terms->linearize(rig, store, window, views, pairs);
  }
  /// All that the points add to the equations.
  bool eliminate(S mu, Equations& equations) {
    pairs.add_to(equations);
    return terms->eliminate(store, mu, pairs, equations);
  }

  bool takes_part(std::size_t i) const { return i != 5 && i != 6; }

  /// All rows of a landmark, or those of one slot.
  DenseRows reference(std::size_t i, int only_slot = -1) const {
    const Landmark& landmark = store.landmarks()[i];
    const Pinhole<double> camera = points.camera;
    const Huber<double> pixel_loss{2.45}, depth_loss{1.345};
    const double lambda = double(landmark.geometry.inverse_range);
    const Vec<double, 3> f = landmark.geometry.bearing.template cast<double>();
    const int a = landmark.anchor;
    const auto current = [&](int k) { return window.T_world_body(k).template cast<double>(); };
    const auto linear = [&](int k) {
      return window[k].state.template get<state::Pose>().first_estimate().template cast<double>();
    };
    DenseRows rows;
    for (int slot = 0; slot < used; ++slot) {
      const typename Kind::Observation& seen = landmark.observations[std::size_t(slot)];
      if (!seen.valid || (only_slot >= 0 && slot != only_slot)) continue;
      const InverseDepth<S>& measured = seen.depth.get();
      const double z = double(measured.value), sigma = double(measured.sigma);
      const Mat<double, 1, 1> L_z(1 / sigma);
      if (slot == a) {
        AnchoredLinearization<double, 1> lin{
            true, Vec<double, 1>(lambda / f.z() - z), {}, {}, Vec<double, 1>(1 / f.z())};
        if (measured.valid) rows.add(lin, L_z, depth_loss, -1, -1);
        continue;
      }
      const InverseDepthReprojection<Pinhole<double>> pixel{seen.uv.template cast<double>()};
      const RelativeView<double> view(current(a), current(slot), T_body_cam);
      const Mat<double, 6, 6> transport = -(linear(slot).inverse() * linear(a)).adjoint();
      auto lin = pixel.linearize(camera, view, f, lambda);
      lin.J_r_anchor = lin.J_r_target * transport;
      rows.add(lin, Mat<double, 2, 2>(seen.L.template cast<double>()), pixel_loss, a, slot);
      if (!measured.valid) continue;
      auto depth = InverseDepthMeasurement<double>{z}.linearize(view, f, lambda);
      depth.J_r_anchor = depth.J_r_target * transport;
      rows.add(depth, L_z, depth_loss, a, slot);
    }
    return rows;
  }
  double reference_cost() const {
    double sum = 0;
    for (std::size_t i = 0; i < store.landmarks().size(); ++i) {
      if (takes_part(i)) sum += reference(i).cost;
    }
    return sum;
  }
};

/// [H b] of the poses without the landmark.
Eigen::MatrixXd schur(const DenseRows& rows, double damping = 0) {
  Eigen::MatrixXd Jr(rows.r.size(), pose_dim + 1);
  Jr << rows.J_p, rows.r;
  const double H_ll = rows.information() + damping;
  const Eigen::MatrixXd H_lp = rows.J_l.transpose() * Jr;
  return Jr.leftCols(pose_dim).transpose() * Jr - H_lp.leftCols(pose_dim).transpose() * H_lp / H_ll;
}

double difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return (a - b).norm() / b.norm(); }

template <class S>
constexpr double tolerance = std::is_same_v<S, float> ? 2e-4 : 1e-9;

}  // namespace

TEMPLATE_TEST_CASE("window_terms (points): the reduced system is that of the dense reference", "", float, double) {
  using S = TestType;
  Scene<S> scene;
  REQUIRE(scene.store.landmarks().size() == 22);
  REQUIRE(scene.linearize() == Approx(scene.reference_cost()).epsilon(tolerance<S>));
  for (const double mu : {1e-4, 1.0}) {
    typename Scene<S>::Equations equations;
    equations.reset(slots);
    REQUIRE(scene.eliminate(S(mu), equations));
    Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(pose_dim, pose_dim + 1);
    for (std::size_t i = 0; i < scene.store.landmarks().size(); ++i) {
      if (!scene.takes_part(i)) continue;
      const DenseRows rows = scene.reference(i);
      expected += schur(rows, mu * damping_scale(rows.information()));
    }
    Eigen::MatrixXd found(pose_dim, pose_dim + 1);
    found.leftCols(pose_dim) = equations.H().template selfadjointView<Eigen::Lower>();
    found.col(pose_dim) = equations.b();
    REQUIRE(difference(found.leftCols(pose_dim), expected.leftCols(pose_dim)) < tolerance<S>);
    REQUIRE(difference(found.col(pose_dim), expected.col(pose_dim)) < 5 * tolerance<S>);
  }
}

TEMPLATE_TEST_CASE("window_terms (points): steps and predicted decrease are those of the whole system", "", float,
                   double) {
  using S = TestType;
  Scene<S> scene;
  const double mu = 0.01, cost = scene.linearize();
  typename Scene<S>::Equations equations;
  equations.reset(slots);
  for (int k = 0; k < slots; ++k) {
    equations.add(k, Mat<double, 6, 6>(10 * Mat<double, 6, 6>::Identity()), Vec<double, 6>(Vec<double, 6>::Zero()),
                  1.0);
  }
  REQUIRE(scene.eliminate(S(mu), equations));
  typename Scene<S>::Equations::Vector d;
  REQUIRE(equations.solve(mu, d));
  const double predicted = equations.predicted_decrease(mu, d) + scene.terms->solve(scene.store, scene.pairs, d, 6);

  // The model's decrease, written out: -d.g - 1/2 d.H d over poses and landmarks, nothing eliminated.
  double expected = -50 * d.squaredNorm();
  std::vector<double> steps;
  for (std::size_t i = 0; i < scene.store.landmarks().size(); ++i) {
    steps.push_back(0);
    if (!scene.takes_part(i)) continue;
    const DenseRows rows = scene.reference(i);
    const Eigen::VectorXd moved = rows.r + rows.J_p * d;
    const double H_ll = rows.information();
    steps[i] = -(rows.J_l.transpose() * moved)(0) / (H_ll + mu * damping_scale(H_ll));
    expected += (rows.r.squaredNorm() - (moved + rows.J_l * steps[i]).squaredNorm()) / 2;
  }
  REQUIRE(predicted == Approx(expected).epsilon(5 * tolerance<S>));
  REQUIRE(predicted > 0);

  std::vector<S> before;
  for (const auto& landmark : scene.store.landmarks()) before.push_back(landmark.geometry.inverse_range);
  scene.terms->step(scene.store);
  for (std::size_t i = 0; i < before.size(); ++i) {
    REQUIRE(double(scene.store.landmarks()[i].geometry.inverse_range - before[i]) ==
            Approx(steps[i]).epsilon(20 * tolerance<S>).margin(tolerance<S>));
  }
  for (int k = 0; k < used; ++k) scene.window.state(k).add(d.template segment<6>(6 * k).template cast<S>());
  scene.views.update(scene.window, scene.T_body_cam.template cast<S>());
  const double after = scene.terms->cost(scene.rig, scene.store, scene.window, scene.views);
  REQUIRE(after == Approx(scene.reference_cost()).epsilon(tolerance<S>));
  REQUIRE(after < cost);

  scene.terms->restore(scene.store);
  for (std::size_t i = 0; i < before.size(); ++i)
    REQUIRE(scene.store.landmarks()[i].geometry.inverse_range == before[i]);
}

TEMPLATE_TEST_CASE("window_terms (points): inverse ranges stay where a point can be", "", float, double) {
  using S = TestType;
  Scene<S> scene;
  auto& landmark = scene.store.landmarks()[1];
  for (auto& seen : landmark.observations) {  // the depths alone decide, and ask for one behind the camera
    seen.L.setZero();
    seen.depth.set({true, S(-1), S(10)});
  }
  scene.linearize();
  typename Scene<S>::Equations equations;
  equations.reset(slots);
  REQUIRE(scene.eliminate(S(0), equations));
  scene.terms->solve(scene.store, scene.pairs, Eigen::VectorXd::Zero(pose_dim).eval(), 6);
  scene.terms->step(scene.store);
  REQUIRE(landmark.geometry.inverse_range == Scene<S>::Kind::lambda_min);
}

TEMPLATE_TEST_CASE("window_terms (points): what leaves with a keyframe, against the dense Schur complement", "", float,
                   double) {
  using S = TestType;
  Scene<S> scene;
  const int leaving = GENERATE(0, 1);
  constexpr int max_rows = Scene<S>::Terms::max_rows;
  BoundedMatrix<double, max_rows, pose_dim + 2> work;
  Eigen::MatrixXd found = Eigen::MatrixXd::Zero(pose_dim, pose_dim + 1), expected = found;
  int anchored = 0, others = 0;
  scene.terms->for_each_leaving(
      leaving, scene.rig, scene.store, scene.window, scene.views, [&](const auto& landmark, const auto&) {
        work.resize(landmark.rows(), pose_dim + 2);
        const int rank = landmark.reduced_rows(work, scene.pairs, 6), n = landmark.rows() - rank;
        const Eigen::MatrixXd rows = work.block(rank, 1, n, pose_dim + 1);
        found += rows.leftCols(pose_dim).transpose() * rows;
      });
  for (std::size_t i = 0; i < scene.store.landmarks().size(); ++i) {
    const auto& landmark = scene.store.landmarks()[i];
    const bool leaves = landmark.anchor == leaving;
    if (!scene.takes_part(i) || !landmark.observations[std::size_t(leaving)].valid) continue;
    const DenseRows rows = leaves ? scene.reference(i) : scene.reference(i, leaving);
    expected += schur(rows);
    ++(leaves ? anchored : others);
  }
  REQUIRE(anchored > 3);
  REQUIRE((leaving == 0 || others > 3));
  REQUIRE(difference(found.leftCols(pose_dim), expected.leftCols(pose_dim)) < tolerance<S>);
  REQUIRE(difference(found.col(pose_dim), expected.col(pose_dim)) < 5 * tolerance<S>);
}

TEMPLATE_TEST_CASE("window_terms (points): after convergence sigmas are set and outliers dropped", "", float, double) {
  using S = TestType;
  Scene<S> scene;
  REQUIRE(scene.store.landmarks()[2].observations[3].valid);
  scene.terms->finish(scene.rig, scene.store, scene.window, scene.views, scene.pairs);
  REQUIRE_FALSE(scene.store.landmarks()[2].observations[3].valid);
  for (std::size_t i = 0; i < scene.store.landmarks().size(); ++i) {
    if (!scene.takes_part(i)) continue;
    REQUIRE(double(scene.store.landmarks()[i].geometry.sigma_inverse_range) ==
            Approx(1 / std::sqrt(scene.reference(i).information())).epsilon(tolerance<S>));
  }
}

TEMPLATE_TEST_CASE("window_terms (points): a state that is no number never costs less", "", float, double) {
  using S = TestType;
  typename Scene<S>::Equations equations;
  equations.reset(slots);
  {
    Scene<S> scene;
    scene.store.landmarks()[1].observations[2].uv.x() = float(not_a_number);
    REQUIRE(std::isnan(scene.linearize()));
    REQUIRE(std::isnan(scene.terms->cost(scene.rig, scene.store, scene.window, scene.views)));
    REQUIRE_FALSE(scene.eliminate(S(1e-4), equations));
    scene.terms->finish(scene.rig, scene.store, scene.window, scene.views,
                        scene.pairs);  // drops it, and all is well again
    REQUIRE_FALSE(scene.store.landmarks()[1].observations[2].valid);
    REQUIRE(std::isfinite(scene.linearize()));
    REQUIRE(scene.eliminate(S(1e-4), equations));
  }
  {
    Scene<S> scene;
    scene.store.landmarks()[0].geometry.inverse_range = S(not_a_number);
    REQUIRE(!(scene.terms->cost(scene.rig, scene.store, scene.window, scene.views) < Scene<S>().reference_cost()));
  }
  {
    Scene<S> scene;
    scene.window.state(2).add(Vec<S, 6>::Constant(S(not_a_number)));
    scene.linearize_views();
    REQUIRE(!(scene.terms->cost(scene.rig, scene.store, scene.window, scene.views) < Scene<S>().reference_cost()));
  }
}
