// The whole solver on a small bundle with outliers, against Ceres: both find the same minimum.
#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/solver/landmark_elimination.hpp"
#include "plumbline/solver/levenberg_marquardt.hpp"
#include "plumbline/solver/robust_loss.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"
#include "random_matrix.hpp"

using namespace plumbline;

namespace {

constexpr int poses = 6, points = 40;
constexpr double sigma_bearing = 2e-3, sigma_range = 0.02, sigma_prior = 1e-3, huber = 2.4477;

/// Bearing and range of a point in the body: h = (x / z, y / z, |q|), q = R^T (X - p).
template <class T>
Vec<T, 3> measure(const Vec<T, 3>& q) {
  using std::sqrt;
  return {q.x() / q.z(), q.y() / q.z(), sqrt(q.x() * q.x() + q.y() * q.y() + q.z() * q.z())};
}
template <class T>
Vec<T, 3> whiten(const Vec<T, 3>& r) {
  return {r.x() / sigma_bearing, r.y() / sigma_bearing, r.z() / sigma_range};
}

struct Observation {
  int pose, point;
  Vec<double, 3> z;
};

struct Bundle {
  std::vector<SE3<double>> T;     // T_world_body
  std::vector<Vec<double, 3>> X;  // in the world
  std::vector<Observation> observations;
  SE3<double> T_prior;  // of pose 0: fixes the gauge

  Bundle() {
    Random random(1);
    const auto noise = [&](double size) { return Vec<double, 3>(size * random_matrix<double, 3, 1>(random)); };
    for (int k = 0; k < poses; ++k)
      T.push_back(SE3<double>(SO3<double>::exp(noise(0.2)), Vec<double, 3>(0.5 * k, 0, 0) + noise(0.2)));
    for (int l = 0; l < points; ++l) X.push_back(Vec<double, 3>(1.5, 0, 6) + noise(3));
    T_prior = T[0];
    for (int l = 0; l < points; ++l) {
      for (int k = 0; k < poses; ++k) {
        const bool outlier = random.uniform() < 0.1;
        const Vec<double, 3> z = measure<double>(T[k].inverse() * X[l]) + noise(outlier ? 0.3 : 3e-3);
        observations.push_back({k, l, z});
      }
    }
    for (SE3<double>& pose : T)
      pose = SE3<double>(pose.rotation() * SO3<double>::exp(noise(0.05)), pose.p() + noise(0.2));
    for (Vec<double, 3>& point : X) point += noise(0.3);
  }

  Vec<double, 3> residual(const Observation& o, const SE3<double>& pose, const Vec<double, 3>& point) const {
    return whiten<double>(measure<double>(pose.inverse() * point) - o.z);
  }
};

/// With plumbline: rows in S, landmarks by QR.
template <class S>
struct Problem {
  Bundle state, trial;
  Huber<double> loss{huber};
  NormalEquations<double, 6, poses> normal;
  std::vector<LandmarkElimination<S, 3, 6, poses, 3 * poses>> landmarks{points};
  RelativeEquations<double, 6, poses> pairs;

  static void jacobians(const SE3<double>& pose, const Vec<double, 3>& point, Mat<double, 3, 6>& J_pose,
                        Mat<double, 3, 3>& J_point) {
    const Vec<double, 3> q = pose.inverse() * point;
    Mat<double, 3, 3> J_q;
    J_q << 1 / q.z(), 0, -q.x() / (q.z() * q.z()), 0, 1 / q.z(), -q.y() / (q.z() * q.z()), q.transpose() / q.norm();
    for (int c = 0; c < 3; ++c) J_q.col(c) = whiten<double>(J_q.col(c));
    J_pose << J_q * hat(q), -J_q;
    J_point = J_q * pose.R().transpose();
  }
  double cost(const Bundle& at) const {
    double sum = (minus(at.T[0], at.T_prior) / sigma_prior).squaredNorm();
    for (const Observation& o : at.observations)
      sum += loss.rho(at.residual(o, at.T[o.pose], at.X[o.point]).squaredNorm());
    return sum / 2;
  }
  double linearize() {
    for (auto& landmark : landmarks) landmark.reset();
    for (const Observation& o : state.observations) {
      const Vec<double, 3> r = state.residual(o, state.T[o.pose], state.X[o.point]);
      Mat<double, 3, 6> J_pose;
      Mat<double, 3, 3> J_point;
      jacobians(state.T[o.pose], state.X[o.point], J_pose, J_point);
      const double w = std::sqrt(loss.weight(r.squaredNorm()));
      landmarks[o.point].add(o.pose, Mat<S, 3, 6>((w * J_pose).cast<S>()), Mat<S, 3, 3>((w * J_point).cast<S>()),
                             Vec<S, 3>((w * r).cast<S>()));
    }
    pairs.reset();
    for (const auto& landmark : landmarks) landmark.add_to(pairs);
    return cost(state);
  }
  bool solve(double mu, double& predicted_decrease) {
    normal.reset(poses);
    normal.add(0, Mat<double, 6, 6>(minus_jacobian(state.T[0], state.T_prior) / sigma_prior),
               Vec<double, 6>(minus(state.T[0], state.T_prior) / sigma_prior), 1.0);
    pairs.add_to(normal);
    for (auto& landmark : landmarks) {
      if (!landmark.eliminate(S(mu), pairs)) return false;
      landmark.subtract_from(normal);
    }
    NormalEquations<double, 6, poses>::Vector d;
    if (!normal.solve(mu, d)) return false;
    predicted_decrease = normal.predicted_decrease(mu, d);
    trial = state;
    for (int k = 0; k < poses; ++k) trial.T[k] = plus(state.T[k], Vec<double, 6>(d.segment<6>(6 * k)));
    for (int l = 0; l < points; ++l) {
      const Vec<S, 3> dl = landmarks[l].back_substitute(d);
      predicted_decrease += landmarks[l].predicted_decrease(dl);
      trial.X[l] += dl.template cast<double>();
    }
    return true;
  }
  double try_step() { return cost(trial); }
  void accept() { state = trial; }
  void reject() {}
};

struct CeresObservation {
  Vec<double, 3> z;
  template <class T>
  bool operator()(const T* q, const T* p, const T* X, T* r) const {
    const Eigen::Quaternion<T> rotation(q[3], q[0], q[1], q[2]);
    const Vec<T, 3> difference = Eigen::Map<const Vec<T, 3>>(X) - Eigen::Map<const Vec<T, 3>>(p);
    const Vec<T, 3> in_body = rotation.conjugate() * difference;
    Eigen::Map<Vec<T, 3>> out(r);
    out = whiten<T>(measure<T>(in_body) - z.cast<T>());
    return true;
  }
};
struct CeresPrior {
  SE3<double> T_prior;
  template <class T>
  bool operator()(const T* q, const T* p, T* r) const {
    const Eigen::Quaternion<T> R0 = T_prior.rotation().quaternion().cast<T>();
    const Eigen::Quaternion<T> dq = R0.conjugate() * Eigen::Quaternion<T>(q[3], q[0], q[1], q[2]);
    const T wxyz[4] = {dq.w(), dq.x(), dq.y(), dq.z()};
    ceres::QuaternionToAngleAxis(wxyz, r);
    Eigen::Map<Vec<T, 3>> dp(r + 3);
    dp = R0.conjugate() * (Eigen::Map<const Vec<T, 3>>(p) - T_prior.p().cast<T>());
    for (int k = 0; k < 6; ++k) r[k] /= T(sigma_prior);
    return true;
  }
};

double solve_with_ceres(Bundle& bundle) {
  std::vector<Vec<double, 4>> q;
  std::vector<Vec<double, 3>> p;
  for (const SE3<double>& T : bundle.T) q.push_back(T.rotation().quaternion().coeffs()), p.push_back(T.p());
  ceres::Problem problem;
  for (int k = 0; k < poses; ++k) problem.AddParameterBlock(q[k].data(), 4, new ceres::EigenQuaternionManifold);
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<CeresPrior, 6, 4, 3>(new CeresPrior{bundle.T_prior}),
                           nullptr, q[0].data(), p[0].data());
  for (const Observation& o : bundle.observations) {
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<CeresObservation, 3, 4, 3, 3>(new CeresObservation{o.z}),
                             new ceres::HuberLoss(huber), q[o.pose].data(), p[o.pose].data(), bundle.X[o.point].data());
  }
  ceres::Solver::Options options;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-15;
  options.gradient_tolerance = 1e-12;
  options.parameter_tolerance = 1e-14;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  for (int k = 0; k < poses; ++k) {
    bundle.T[k] = SE3<double>(SO3<double>(Eigen::Quaterniond(q[k].data())), p[k]);
  }
  return summary.final_cost;
}

}  // namespace

TEST_CASE("levenberg_marquardt: the Jacobians of this test") {
  const Bundle bundle;
  for (int k = 0; k < 20; ++k) {
    const Observation& o = bundle.observations[k];
    Mat<double, 3, 6> J_pose;
    Mat<double, 3, 3> J_point;
    Problem<double>::jacobians(bundle.T[o.pose], bundle.X[o.point], J_pose, J_point);
    REQUIRE(testing::jacobian_error(
                J_pose, [&](const SE3<double>& T) { return bundle.residual(o, T, bundle.X[o.point]); },
                bundle.T[o.pose]) < 1e-8);
    REQUIRE(testing::jacobian_error(
                J_point, [&](const Vec<double, 3>& X) { return bundle.residual(o, bundle.T[o.pose], X); },
                bundle.X[o.point]) < 1e-8);
  }
}

TEMPLATE_TEST_CASE("levenberg_marquardt: same minimum as Ceres", "", float, double) {
  Bundle expected;
  const double expected_cost = solve_with_ceres(expected);
  auto problem = std::make_unique<Problem<TestType>>();
  const auto summary = levenberg_marquardt(*problem, {.max_iterations = 200, .relative_cost_tolerance = 1e-15});
  REQUIRE(summary.termination == LevenbergMarquardtEnd::converged);
  REQUIRE(summary.initial_cost > 5 * expected_cost);
  REQUIRE(summary.final_cost == Approx(expected_cost).epsilon(1e-9));
  REQUIRE(problem->cost(expected) == Approx(expected_cost).epsilon(1e-12));  // one and the same problem
  for (int k = 0; k < poses; ++k) REQUIRE(minus(problem->state.T[k], expected.T[k]).norm() < 1e-5);
  for (int l = 0; l < points; ++l) REQUIRE((problem->state.X[l] - expected.X[l]).norm() < 1e-4);
}
