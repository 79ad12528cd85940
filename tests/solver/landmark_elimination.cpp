#include "plumbline/solver/landmark_elimination.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <limits>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "random_matrix.hpp"

using namespace plumbline;

namespace {

constexpr int pose_dim = 6, poses = 5, landmarks = 4;

/// The rows of all landmarks as one dense matrix [landmarks | poses], and what the solver must make of them. Not a
/// template, all in double.
struct Dense {
  int landmark_columns, dim;
  Eigen::MatrixXd J;
  Eigen::VectorXd r;

  Dense(int of_landmarks, int of_poses)
      : landmark_columns(of_landmarks), dim(of_poses), J(0, of_landmarks + of_poses) {}

  void add(const Eigen::MatrixXd& J_l, int l, const Eigen::MatrixXd& J_i, int i, const Eigen::MatrixXd& J_j, int j,
           const Eigen::VectorXd& res) {
    const int first = int(J.rows()), n = int(res.size());
    J.conservativeResize(first + n, Eigen::NoChange);
    r.conservativeResize(first + n);
    J.bottomRows(n).setZero();
    J.block(first, l, n, J_l.cols()) = J_l;
    if (i >= 0) J.block(first, landmark_columns + i, n, pose_dim) = J_i;
    if (j >= 0) J.block(first, landmark_columns + j, n, pose_dim) = J_j;
    r.tail(n) = res;
  }
  /// Q2^T of the landmarks' columns, applied to the poses' columns and to r.
  Eigen::MatrixXd reduced() const {
    Eigen::MatrixXd rows(J.rows(), dim + 1);
    rows << J.rightCols(dim), r;
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(J.leftCols(landmark_columns));
    return Eigen::MatrixXd(qr.householderQ().transpose() * rows).bottomRows(J.rows() - landmark_columns);
  }
  Eigen::MatrixXd reduced_H() const {
    const Eigen::MatrixXd rows = reduced();
    return (rows.transpose() * rows).topLeftCorner(dim, dim);
  }
  Eigen::VectorXd reduced_b() const {
    const Eigen::MatrixXd rows = reduced();
    return (rows.transpose() * rows).col(dim).head(dim);
  }
  /// The step of the full system with `information` on each pose parameter and H += diag(damping), and the decrease of
  /// the undamped model that it promises.
  Eigen::VectorXd step(double information, const Eigen::VectorXd& damping, double& decrease) const {
    Eigen::MatrixXd H = J.transpose() * J;
    H.diagonal().tail(dim).array() += information;
    const Eigen::VectorXd b = J.transpose() * r;
    Eigen::MatrixXd damped = H;
    damped.diagonal() += damping;
    Eigen::VectorXd d = -(damped.inverse() * b);
    const Eigen::VectorXd Hd = H * d;
    decrease = -d.dot(b) - d.dot(Hd) / 2;
    return d;
  }
};

/// Random columns of this condition number, singular values in geometric progression from 1.
Eigen::MatrixXd columns_of_condition(Random& random, int rows, int cols, double condition) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> left(random_matrix(random, rows, cols)),
      right(random_matrix(random, cols, cols));
  Eigen::MatrixXd out = right.householderQ();
  for (int k = 1; k < cols; ++k) out.row(k) *= std::pow(condition, -double(k) / (cols - 1));
  return rounded(left.householderQ() * Eigen::MatrixXd::Identity(rows, cols) * out);
}

/// Landmarks seen from random poses, all but one of them anchored in a pose of their own. Block columns of the poses
/// are NormalDim wide, of which the landmarks see the leading six. `condition` is that of a landmark's columns.
template <class S, int L, class Acc = double, int NormalDim = pose_dim>
struct Problem {
  static constexpr int dim = NormalDim * poses;
  using Normal = NormalEquations<double, NormalDim, poses>;
  using Elimination = LandmarkElimination<S, L, pose_dim, poses, 64, Acc>;
  std::vector<Elimination> eliminations;
  typename Elimination::Pairs pairs;
  Dense dense;

  explicit Problem(std::uint64_t seed, int count = landmarks, double condition = 1.0)
      : eliminations(count), dense(count * L, dim) {
    Random random(seed);
    for (int a = 0; a < poses; ++a) {
      for (int j = 0; j < poses; ++j) {
        if (a != j) pairs.set_transport(a, j, random_matrix<Acc, pose_dim, pose_dim>(random));
      }
    }
    pairs.reset();
    for (int l = 0; l < count; ++l) {
      const Eigen::MatrixXd J_l = columns_of_condition(random, 29, L, condition);
      const int anchor = l == 1 ? Elimination::no_anchor : l % poses;
      const auto other = [&] { return (anchor + 1 + int(random.below(poses - 1))) % poses; };
      eliminations[l].reset(anchor);
      for (int o = 0; o < 8; ++o) add<2>(random, J_l, l, anchor, other());
      add<7>(random, J_l, l, anchor, other());  // more rows than a group holds
      add<5>(random, J_l, l, anchor, other());
      add<1>(random, J_l, l, anchor, -1);
      eliminations[l].add_to(pairs);
    }
  }

  template <int R>
  void add(Random& random, const Eigen::MatrixXd& all_J_l, int l, int anchor, int j) {
    const Mat<S, R, L> J_l = all_J_l.middleRows<R>(eliminations[l].rows()).template cast<S>();
    const Mat<S, R, pose_dim> J = random_matrix<S, R, pose_dim>(random);
    const Vec<S, R> r = random_matrix<S, R, 1>(random);
    REQUIRE((j < 0 ? eliminations[l].add(J_l, r) : eliminations[l].add(j, J, J_l, r)));
    Eigen::MatrixXd J_anchor;
    if (anchor >= 0 && j >= 0) {
      J_anchor = -J.template cast<double>() * pairs.transport(anchor, j).template cast<double>();
    } else {
      anchor = -1;
    }
    dense.add(J_l.template cast<double>(), l * L, J_anchor, anchor * NormalDim, J.template cast<double>(),
              j * NormalDim, r.template cast<double>());
  }
};

/// Reduced system, step and predicted decrease against the dense full problem; the arithmetic is in double.
template <class S, int L, int NormalDim>
void check() {
  using P = Problem<S, L, double, NormalDim>;
  P problem(11);
  const Dense& dense = problem.dense;
  const double tolerance = sizeof(S) == 4 ? 2e-6 : 1e-10;
  const auto normal = std::make_unique<typename P::Normal>();
  for (const double mu : {0.0, 1e-4, 0.1, 10.0}) {
    normal->reset(poses);
    problem.pairs.add_to(*normal);
    for (auto& landmark : problem.eliminations) {
      REQUIRE(landmark.eliminate(S(mu), problem.pairs));
      landmark.subtract_from(*normal);
    }
    if (mu == 0) {
      REQUIRE(relative_error(symmetric(normal->H()), dense.reduced_H()) < 1e-13);
      REQUIRE(relative_error(normal->b(), dense.reduced_b()) < 1e-13);
      REQUIRE(normal->cost() == 0.0);
    }
    // Blocks wider than the landmarks' Jacobians need something that holds their other parameters.
    const Mat<double, NormalDim, NormalDim> anchor = Mat<double, NormalDim, NormalDim>::Identity();
    const Vec<double, NormalDim> zero = Vec<double, NormalDim>::Zero();
    for (int i = 0; i < poses; ++i) normal->add(i, anchor, zero, 0.25);
    // The full system: landmarks damped by their own diagonal, poses by that of the reduced system.
    Eigen::VectorXd damping(dense.J.cols());
    damping << dense.J.leftCols(landmarks * L).colwise().squaredNorm().transpose(), normal->H().diagonal();
    double decrease = 0;
    const Eigen::VectorXd expected = dense.step(0.25, mu * damping, decrease);
    typename P::Normal::Vector d;
    REQUIRE(normal->solve(mu, d));
    REQUIRE(relative_error(d, expected.tail(P::dim)) < tolerance);
    double predicted = normal->predicted_decrease(mu, d);
    for (int l = 0; l < landmarks; ++l) {
      const Vec<S, L> dl = problem.eliminations[l].back_substitute(d, NormalDim);
      REQUIRE(relative_error(dl.template cast<double>(), expected.segment(l * L, L)) < tolerance);
      predicted += problem.eliminations[l].predicted_decrease(dl);
      auto relative = problem.eliminations[l];  // the same without columns of the anchor
      REQUIRE(relative.eliminate(S(mu)));
      REQUIRE(relative.is_complete() == (relative.anchor() < 0));
      if (relative.is_complete()) continue;
      const Vec<S, L> by_relative =
          relative.back_substitute_relative(problem.pairs.steps(relative.anchor(), d, NormalDim));
      REQUIRE(relative_error(by_relative.template cast<double>(), dl.template cast<double>()) < tolerance);
    }
    REQUIRE(predicted == Approx(decrease).epsilon(tolerance));
  }
}

}  // namespace

TEST_CASE("landmark_elimination: reduced system and step equal those of the full problem") {
  check<float, 1, 6>();
  check<double, 4, 15>();
}

TEST_CASE("landmark_elimination: float, landmark block of condition 1e4") {
  for (const std::uint64_t seed : {5, 6, 7}) {
    Problem<float, 4, float> problem(seed, 1, 1e4);
    NormalEquations<float, 6, poses> normal;
    normal.reset(poses);
    REQUIRE(problem.eliminations[0].eliminate(0.0f, problem.pairs));
    problem.pairs.add_to(normal);
    problem.eliminations[0].subtract_from(normal);
    const Eigen::MatrixXd expected = problem.dense.reduced_H();
    const double qr = relative_error(symmetric(normal.H()), expected);
    const Eigen::MatrixXf J = problem.dense.J.cast<float>(), H = J.transpose() * J;
    const Mat<float, 4, 4> inverse = Mat<float, 4, 4>(H.topLeftCorner<4, 4>()).inverse();
    const Eigen::MatrixXf H_lp = H.topRightCorner(4, 30), gain = inverse * H_lp;
    const Eigen::MatrixXf schur = H.bottomRightCorner(30, 30) - H_lp.transpose() * gain;
    const double plain = relative_error(schur.cast<double>(), expected);
    CAPTURE(qr, plain);
    REQUIRE(qr < 1e-4);
    REQUIRE(plain > 1e-2);
  }
}

TEST_CASE("landmark_elimination: rows for marginalization are the full complement") {
  Problem<float, 4, float> problem(8, 1);
  auto& landmark = problem.eliminations[0];
  Eigen::MatrixXd work = Eigen::MatrixXd::Constant(64, 4 + problem.dim + 1, 7.0);
  const int rank = landmark.reduced_rows(work, problem.pairs);
  REQUIRE(rank == 4);
  const Eigen::MatrixXd rows = work.block(rank, 4, landmark.rows() - rank, problem.dim + 1),
                        expected = problem.dense.reduced();
  REQUIRE(relative_error(rows.transpose() * rows, expected.transpose() * expected) < 1e-13);
}

TEST_CASE("landmark_elimination: an undetermined landmark") {
  Random random(9);
  LandmarkElimination<double, 3, 6, 4, 32> landmark;
  const RelativeEquations<double, 6, 4> pairs{};
  Mat<double, 3, 3> covariance;
  REQUIRE_FALSE(landmark.eliminate(0, pairs));  // no rows
  REQUIRE_FALSE(landmark.covariance(covariance));
  Mat<double, 2, 3> J_l = random_matrix<double, 2, 3>(random);
  J_l.col(2).setZero();
  const Mat<double, 2, 6> J_p = random_matrix<double, 2, 6>(random);
  const Vec<double, 2> r = random_matrix<double, 2, 1>(random);
  for (int i = 0; i < 4; ++i) REQUIRE(landmark.add(i, J_p, J_l, r));
  REQUIRE_FALSE(landmark.covariance(covariance));
  REQUIRE_FALSE(landmark.eliminate(0, pairs));
  REQUIRE(landmark.eliminate(1e-4, pairs));
  REQUIRE(landmark.back_substitute(Eigen::VectorXd::Zero(24)).allFinite());
  Eigen::MatrixXd work(8, 3 + 24 + 1);
  REQUIRE(landmark.reduced_rows(work, pairs) == 2);
}

TEST_CASE("landmark_elimination: refuses what is not finite, and what is too much") {
  const Vec<float, 2> ones = Vec<float, 2>::Ones();
  const Mat<float, 2, 6> J = Mat<float, 2, 6>::Ones();
  const RelativeEquations<double, 6, 4> pairs{};
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    LandmarkElimination<float, 1, 6, 4, 8> in_J_l, in_J_p, in_r;
    for (auto* landmark : {&in_J_l, &in_J_p, &in_r}) {
      REQUIRE(landmark->add(1, J, ones, ones));
      REQUIRE(landmark->eliminate(0, pairs));
    }
    REQUIRE(in_J_l.add(1, J, Vec<float, 2>(1, bad), ones));
    REQUIRE(in_J_p.add(1, Mat<float, 2, 6>(bad * J), ones, ones));
    REQUIRE(in_r.add(1, J, ones, Vec<float, 2>(bad, 1)));
    for (auto* landmark : {&in_J_l, &in_J_p, &in_r}) {
      REQUIRE_FALSE(landmark->eliminate(0, pairs));
      REQUIRE_FALSE(landmark->eliminate(1, pairs));
    }
  }
  LandmarkElimination<float, 1, 6, 4, 8> full;
  for (int k = 0; k < 3; ++k) REQUIRE(full.add(3, J, ones, ones));
  REQUIRE_FALSE(
      full.add(1, Mat<float, 3, 6>(Mat<float, 3, 6>::Ones()), Vec<float, 3>(1, 1, 1), Vec<float, 3>(1, 1, 1)));
  REQUIRE(full.rows() == 6);
  REQUIRE(full.add(ones, ones));
  REQUIRE_FALSE(full.add(Vec<float, 1>(1.0f), Vec<float, 1>(1.0f)));
  full.reset();
  REQUIRE(full.rows() == 0);
}

TEST_CASE("landmark_elimination: covariance of the landmark, the poses given") {
  Random random(3);
  LandmarkElimination<double, 4, pose_dim, poses, 12> rows;
  const Mat<double, 12, 4> J = random_matrix<double, 12, 4>(random);
  rows.add<12>(J, Vec<double, 12>::Zero());
  Mat<double, 4, 4> covariance;
  REQUIRE(rows.covariance(covariance));
  REQUIRE((covariance * J.transpose() * J - Mat<double, 4, 4>::Identity()).norm() < 1e-12);
}

namespace {

/// Two landmarks, one of one parameter and one of four, each with rows of its own and two of both, in the order
/// [point | line | poses] of a dense matrix.
struct Tied {
  static constexpr int dim = pose_dim * poses, columns = 1 + 4 + dim;
  LandmarkElimination<double, 1, pose_dim, poses, 32> point;
  LandmarkElimination<double, 4, pose_dim, poses, 32> line;
  LandmarkElimination<double, 1, pose_dim, poses, 32>::Pairs pairs;
  NormalEquations<double, pose_dim, poses> normal;
  BlockRows<double, 2, pose_dim, poses, 4> tie;
  std::array<Vec<double, 1>, 2> tie_by_point;
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(0, columns);
  Eigen::VectorXd r;

  explicit Tied(std::uint64_t seed) {
    Random random(seed);
    for (int a = 0; a < poses; ++a) {
      for (int j = 0; j < poses; ++j) {
        if (a != j) pairs.set_transport(a, j, random_matrix<double, pose_dim, pose_dim>(random));
      }
    }
    pairs.reset();
    point.reset(0);
    line.reset(2);
    for (const int j : {1, 3}) add<1>(random, point, 0, 0, j);
    for (const int j : {0, 1, 4}) add<4>(random, line, 1, 2, j);
    point.add_to(pairs);
    line.add_to(pairs);
    const Mat<double, 2, columns> rows = random_matrix<double, 2, columns>(random);
    const Vec<double, 2> residual = random_matrix<double, 2, 1>(random);
    append(rows, residual);
    tie.touched.reset();
    for (int k = 0; k < 2; ++k) {
      tie_by_point[k][0] = rows(k, 0);
      for (int c = 0; c < 4; ++c) tie.J_other[k][c] = rows(k, 1 + c);
      tie.r[k] = residual[k];
      for (const int j : {0, 2}) {  // the point's anchor and the line's
        tie.touched[j] = true;
        tie.J[j][k] = rows.block<1, pose_dim>(k, 5 + j * pose_dim).transpose();
      }
    }
    for (const int j : {1, 3, 4}) J.bottomRows(2).middleCols(5 + j * pose_dim, pose_dim).setZero();
  }

  template <int L, class Elimination>
  void add(Random& random, Elimination& landmark, int column, int anchor, int j) {
    const Mat<double, 2, pose_dim> J_j = random_matrix<double, 2, pose_dim>(random);
    const Mat<double, 2, L> J_l = random_matrix<double, 2, L>(random);
    const Vec<double, 2> residual = random_matrix<double, 2, 1>(random);
    REQUIRE(landmark.template add<2>(j, J_j, J_l, residual));
    Mat<double, 2, columns> rows = Mat<double, 2, columns>::Zero();
    rows.template middleCols<L>(column) = J_l;
    rows.template middleCols<pose_dim>(5 + j * pose_dim) = J_j;
    rows.template middleCols<pose_dim>(5 + anchor * pose_dim) = -J_j * pairs.transport(anchor, j);
    append(rows, residual);
  }
  void append(const Mat<double, 2, columns>& rows, const Vec<double, 2>& residual) {
    J.conservativeResize(J.rows() + 2, Eigen::NoChange);
    r.conservativeResize(r.size() + 2);
    J.bottomRows<2>() = rows;
    r.tail<2>() = residual;
  }
};

}  // namespace

TEST_CASE("landmark_elimination: rows that depend on two landmarks") {
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    for (const double mu : {0.0, 0.3}) {
      Tied tied(seed);
      tied.normal.reset(poses);
      for (int i = 0; i < poses; ++i) {
        tied.normal.add_block(i, i,
                              Mat<double, pose_dim, pose_dim>(0.25 * Mat<double, pose_dim, pose_dim>::Identity()));
      }
      REQUIRE(tied.point.eliminate(mu, tied.pairs));
      REQUIRE(tied.line.eliminate(mu, tied.pairs));
      tied.pairs.add_to(tied.normal);
      tied.point.subtract_from(tied.normal);
      tied.line.subtract_from(tied.normal);
      const Mat<double, 1, 4> B = tied.point.absorb(tied.tie_by_point, tied.tie);
      std::array<Vec<double, 4>, 2> by_line = tied.tie.J_other;
      BlockRows<double, 2, pose_dim, poses, 1> left{tied.tie.touched, tied.tie.J, {}, tied.tie.r};
      for (auto& none : left.J_other) none.setZero();
      tied.line.absorb(by_line, left);
      left.add_to(tied.normal);

      // The landmarks are damped by the diagonal of their own rows, without the common ones.
      Eigen::MatrixXd H = tied.J.transpose() * tied.J;
      Eigen::VectorXd damping = Eigen::VectorXd::Zero(Tied::columns);
      damping.head(5) = mu * tied.J.topRows(tied.J.rows() - 2).leftCols(5).colwise().squaredNorm().transpose();
      damping.tail(Tied::dim) = mu * tied.normal.H().diagonal();
      H.diagonal().tail(Tied::dim).array() += 0.25;
      const Eigen::VectorXd b = tied.J.transpose() * tied.r;
      Eigen::MatrixXd damped = H;
      damped.diagonal() += damping;
      const Eigen::VectorXd expected = -(damped.inverse() * b), H_expected = H * expected;

      NormalEquations<double, pose_dim, poses>::Vector d;
      REQUIRE(tied.normal.solve(mu, d));
      REQUIRE((d - expected.tail(Tied::dim)).norm() < 1e-9 * expected.norm());
      const Vec<double, 4> d_line = tied.line.back_substitute(d);
      REQUIRE((d_line - expected.segment<4>(1)).norm() < 1e-9 * expected.norm());
      const Vec<double, 1> d_point = tied.point.back_substitute(d, pose_dim, Vec<double, 1>(B * d_line));
      REQUIRE(std::abs(d_point[0] - expected[0]) < 1e-9 * expected.norm());
      const double predicted = tied.normal.predicted_decrease(mu, d) + tied.line.predicted_decrease(d_line) +
                               tied.point.predicted_decrease(d_point);
      REQUIRE(predicted == Approx(-expected.dot(b) - expected.dot(H_expected) / 2).epsilon(1e-9));
    }
  }
}
