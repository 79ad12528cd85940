// The linear algebra of one window iteration: 10 poses, 150 landmarks with 10 observations of 3 rows each.
#include "plumbline/solver/landmark_elimination.hpp"

#include <benchmark/benchmark.h>

#include <memory>
#include <vector>

#include "plumbline/core/random.hpp"
#include "plumbline/solver/marginalization.hpp"

namespace plumbline {
namespace {

constexpr int blocks = 10, landmarks = 150, observations = 10, rows = 3;

template <class M>
M random_matrix(Random& random) {
  M out;
  for (int i = 0; i < out.size(); ++i) out.data()[i] = typename M::Scalar(2 * random.uniform() - 1);
  return out;
}

template <class S, int L>
struct Observation {
  int target;
  Mat<S, rows, 6> J;
  Mat<S, rows, L> J_l;
  Vec<S, rows> r;
};

template <class S, int L, int NormalDim = 6>
struct Window {
  using Normal = NormalEquations<double, NormalDim, blocks>;
  using Landmark = LandmarkElimination<S, L, 6, blocks, observations * rows>;
  std::vector<Observation<S, L>> data;
  std::vector<Landmark> eliminations{landmarks};
  std::unique_ptr<Normal> normal = std::make_unique<Normal>();
  RelativeEquations<double, 6, blocks> pairs;

  Window() {
    Random random(7);
    for (int a = 0; a < blocks; ++a) {
      for (int j = 0; j < blocks; ++j) {
        if (a != j) pairs.set_transport(a, j, random_matrix<Mat<double, 6, 6>>(random));
      }
    }
    for (int l = 0; l < landmarks; ++l) {
      for (int k = 0; k < observations; ++k) {
        data.push_back({(l + 1 + k % (blocks - 1)) % blocks, random_matrix<Mat<S, rows, 6>>(random),
                        random_matrix<Mat<S, rows, L>>(random), random_matrix<Vec<S, rows>>(random)});
      }
    }
  }
  void add() {
    pairs.reset();
    for (int l = 0; l < landmarks; ++l) {
      eliminations[l].reset(l % blocks);
      for (int k = 0; k < observations; ++k) {
        const Observation<S, L>& o = data[l * observations + k];
        eliminations[l].template add<rows>(o.target, o.J, o.J_l, o.r);
      }
      eliminations[l].add_to(pairs);
    }
  }
  void eliminate() {
    for (Landmark& landmark : eliminations) benchmark::DoNotOptimize(landmark.eliminate(S(1e-4), pairs));
  }
  void accumulate() {
    normal->reset(blocks);
    pairs.add_to(*normal);
    for (const Landmark& landmark : eliminations) landmark.subtract_from(*normal);
  }
  void solve() {
    typename Normal::Vector d;
    benchmark::DoNotOptimize(normal->solve(1e-4, d));
    for (const Landmark& landmark : eliminations) benchmark::DoNotOptimize(landmark.back_substitute(d, NormalDim));
  }
};

template <class S, int L, int NormalDim>
void landmark_elimination_window(benchmark::State& state) {
  Window<S, L, NormalDim> window;
  for (auto _ : state) {
    window.add();
    window.eliminate();
    window.accumulate();
    window.solve();
  }
  state.SetItemsProcessed(state.iterations() * landmarks * observations);
}
BENCHMARK_TEMPLATE(landmark_elimination_window, float, 1, 6)->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(landmark_elimination_window, double, 1, 6)->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(landmark_elimination_window, float, 4, 6)->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(landmark_elimination_window, float, 1, 15)->Unit(benchmark::kMicrosecond);

template <class S>
void landmark_elimination_add(benchmark::State& state) {
  Window<S, 1> window;
  for (auto _ : state) window.add();
}
BENCHMARK_TEMPLATE(landmark_elimination_add, float)->Unit(benchmark::kMicrosecond);

template <class S>
void landmark_elimination_eliminate(benchmark::State& state) {
  Window<S, 1> window;
  window.add();
  for (auto _ : state) window.eliminate();
}
BENCHMARK_TEMPLATE(landmark_elimination_eliminate, float)->Unit(benchmark::kMicrosecond);

template <class S>
void landmark_elimination_add_to(benchmark::State& state) {
  Window<S, 1> window;
  window.add();
  window.eliminate();
  for (auto _ : state) window.accumulate();
}
BENCHMARK_TEMPLATE(landmark_elimination_add_to, float)->Unit(benchmark::kMicrosecond);

template <int NormalDim>
void normal_equations_solve(benchmark::State& state) {
  Window<float, 1, NormalDim> window;
  window.add();
  window.eliminate();
  window.accumulate();
  for (auto _ : state) window.solve();
}
BENCHMARK_TEMPLATE(normal_equations_solve, 6)->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(normal_equations_solve, 15)->Unit(benchmark::kMicrosecond);

/// A keyframe leaves: the rows of 30 landmarks, then (IMU) rows that couple two states.
template <int NormalDim>
void marginalize_keyframe(benchmark::State& state) {
  constexpr int dim = NormalDim * blocks;
  Window<float, 1, NormalDim> window;
  window.add();
  auto marginalizer = std::make_unique<Marginalizer<dim, 64>>();
  auto prior = std::make_unique<Prior<dim>>();
  auto work = std::make_unique<BoundedMatrix<double, observations * rows, dim + 2>>();
  work->resize(observations * rows, dim + 2);
  Random random(3);
  const Mat<double, 15, NormalDim> J_i = random_matrix<Mat<double, 15, NormalDim>>(random),
                                   J_j = random_matrix<Mat<double, 15, NormalDim>>(random);
  const Vec<double, 15> r = random_matrix<Vec<double, 15>>(random);
  for (auto _ : state) {
    marginalizer->reset(dim);
    for (int l = 0; l < landmarks; l += 5) {
      const int rank = window.eliminations[l].reduced_rows(*work, window.pairs, NormalDim),
                n = window.eliminations[l].rows() - rank;
      marginalizer->add_rows(work->block(rank, 1, n, dim), work->col(dim + 1).segment(rank, n));
    }
    marginalizer->add_rows(J_i, 0, J_j, NormalDim, r);
    benchmark::DoNotOptimize(marginalizer->marginalize(0, NormalDim, *prior));
  }
}
BENCHMARK_TEMPLATE(marginalize_keyframe, 6)->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(marginalize_keyframe, 15)->Unit(benchmark::kMicrosecond);

template <int Dim>
void prior_information(benchmark::State& state) {
  Prior<Dim> prior;
  prior.J0 = Eigen::MatrixXd::Random(Dim, Dim).triangularView<Eigen::Upper>().toDenseMatrix();
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(Dim, Dim);
  for (auto _ : state) prior.information(H);
}
BENCHMARK_TEMPLATE(prior_information, 60)->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(prior_information, 150)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace plumbline

BENCHMARK_MAIN();
