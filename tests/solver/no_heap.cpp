// Nothing in solver/ allocates: neither through Eigen (checked also in release builds) nor through operator new.
#include "allocation_counter.hpp"

#include <memory>

#include "catch.hpp"
#include "plumbline/solver/gauss_newton.hpp"
#include "plumbline/solver/landmark_elimination.hpp"
#include "plumbline/solver/levenberg_marquardt.hpp"
#include "plumbline/solver/marginalization.hpp"
#include "plumbline/solver/normal_equations.hpp"
#include "plumbline/solver/robust_loss.hpp"

using namespace plumbline;
using test::allocations_of;

namespace {

/// One window iteration after the other, as large as a window with an IMU gets: 10 blocks of 15.
template <class S, int L>
struct Window {
  static constexpr int blocks = 10, block_dim = 15, dim = blocks * block_dim;
  using Normal = NormalEquations<double, block_dim, blocks>;
  Normal normal;
  LandmarkElimination<S, L, 6, blocks, 40> landmark;
  RelativeEquations<double, 6, blocks> pairs;
  Marginalizer<dim, 32> marginalizer;
  Prior<dim> prior, copy;
  BoundedMatrix<double, dim, dim> prior_H;
  BoundedMatrix<double, 40, L + dim + 1> work;
  typename Normal::Vector d, e;
  Mat<double, block_dim, block_dim> covariance;
  bool ok = true;

  Window() {
    prior_H.resize(dim, dim);
    prior_H.setZero();
  }

  double linearize() {
    if (prior.empty()) {
      normal.reset(blocks);
    } else {
      prior.information(prior_H);
      normal.reset(blocks);
      normal.add(prior_H);
      e.setConstant(dim - block_dim, 0.1);
      normal.add_cost(prior.residual(e).squaredNorm());
    }
    landmark.reset(0);
    pairs.reset();
    for (int k = 1; k < blocks; ++k) {
      Mat<S, 3, 6> J;
      Mat<S, 3, L> J_l;
      for (int c = 0; c < 18; ++c) J.data()[c] = S(c % 5) + S(k % 3);
      pairs.set_transport(0, k, Mat<double, 6, 6>(double(k) * Mat<double, 6, 6>::Identity()));
      for (int c = 0; c < 3 * L; ++c) J_l.data()[c] = S((c * k) % 4) + S(0.5);
      const Vec<S, 3> r(S(1), S(2), S(k));
      const S weight = Huber<S>().weight(r.squaredNorm());
      normal.add_cost(double(Huber<S>().rho(r.squaredNorm())));
      ok = ok && landmark.add(k, J, J_l, Vec<S, 3>(std::sqrt(weight) * r));
    }
    landmark.add_to(pairs);
    pairs.add_to(normal);
    const Mat<double, 15, 15> I = Mat<double, 15, 15>::Identity(), minus_I = -I;
    for (int k = 0; k < blocks; ++k) normal.add(k, I, Vec<double, 15>(Vec<double, 15>::Ones()), 0.5);
    for (int k = 1; k < blocks; ++k) normal.add(k, I, k - 1, minus_I, Vec<double, 15>(Vec<double, 15>::Ones()), 2.0);
    return normal.cost();
  }
  bool solve(double mu, double& predicted_decrease) {
    ok = ok && landmark.eliminate(S(mu), pairs);
    landmark.subtract_from(normal);
    const bool solved = normal.solve(mu, d) && normal.covariance_block(3, covariance);
    predicted_decrease = normal.predicted_decrease(mu, d);
    predicted_decrease += landmark.predicted_decrease(landmark.back_substitute(d, block_dim));
    return solved;
  }
  double try_step() { return normal.cost() * 0.9; }
  void accept() {}
  void reject() {}

  void marginalize() {
    work.resize(40, L + dim + 1);
    const int rank = landmark.reduced_rows(work, pairs, block_dim), n = landmark.rows() - rank;
    marginalizer.reset(dim);
    marginalizer.add_rows(work.block(rank, L, n, dim), work.col(L + dim).segment(rank, n));
    const Mat<double, 15, 15> I = Mat<double, 15, 15>::Identity();
    for (int k = 1; k < blocks; ++k) marginalizer.add_rows(I, 15 * k, I, 15 * k - 15, Vec<double, 15>::Ones());
    marginalizer.add_rows(I, Vec<double, 15>::Ones(), 30);
    ok = ok && marginalizer.marginalize(15, 15, prior);
    copy = prior;
  }
};

template <class S, int L>
void check() {
  auto window = std::make_unique<Window<S, L>>();
  const long count = allocations_of([&] {
    for (int k = 0; k < 3; ++k) {
      const auto summary = levenberg_marquardt(*window);
      window->ok = window->ok && summary.iterations > 0;
      window->marginalize();
    }
    DenseNormalEquations<S, 6> pose;
    pose.add(Mat<S, 6, 6>(Mat<S, 6, 6>::Identity()), Vec<S, 6>(Vec<S, 6>::Ones()), S(1));
    Vec<S, 6> d;
    Mat<S, 6, 6> covariance;
    window->ok = window->ok && pose.solve(d) && pose.covariance(covariance);
  });
  REQUIRE(window->ok);
  REQUIRE(count == 0);
}

}  // namespace

TEST_CASE("no_heap: the watch sees what it should") {
  REQUIRE(allocations_of([] { REQUIRE(std::make_unique<int>(3)); }) > 0);
  REQUIRE(allocations_of([] {
            volatile int n = 50;
            Eigen::MatrixXd heap(n, n);
            heap.setZero();
          }) > 0);
}

TEST_CASE("no_heap: window iterations, marginalization and pose solver") {
  check<float, 1>();
  check<double, 1>();
  check<float, 4>();
}
