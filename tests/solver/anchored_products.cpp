#include "plumbline/solver/anchored_products.hpp"

#include <memory>

#include "catch.hpp"
#include "random_matrix.hpp"

using namespace plumbline;

namespace {

constexpr int block_dim = 6, blocks = 5, normal_dim = 7, dim = normal_dim * blocks;
using Pairs = RelativeEquations<double, block_dim, blocks>;
using Products = AnchoredProducts<double, block_dim, blocks>;

/// A landmark of R columns that some blocks see: gives its products, and takes those of A with its anchor's columns.
template <std::size_t R>
void add_landmark(Random& random, int anchor, const Pairs& pairs, Products& products, Eigen::MatrixXd& H,
                  Eigen::VectorXd& b) {
  std::bitset<blocks> touched;
  std::array<std::array<Vec<double, block_dim>, R>, blocks> A;
  const Vec<double, int(R)> c = random_matrix<double, int(R), 1>(random);
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(R, dim);
  for (int j = 0; j < blocks; ++j) {
    touched[std::size_t(j)] = j != anchor && random.below(3) > 0;
    if (!touched[std::size_t(j)]) continue;
    for (std::size_t k = 0; k < R; ++k) {
      const Vec<double, block_dim> row = A[std::size_t(j)][k] = random_matrix<double, block_dim, 1>(random);
      all.block<1, block_dim>(Eigen::Index(k), j * normal_dim) = row.transpose();
      all.block<1, block_dim>(Eigen::Index(k), anchor * normal_dim) -= row.transpose() * pairs.transport(anchor, j);
    }
  }
  products.add(touched, A, c);
  H -= all.transpose() * all;
  b -= all.transpose() * c;
}

}  // namespace

TEST_CASE("anchored_products: sums over landmarks are those of their columns written out") {
  Random random(1);
  Pairs pairs;
  for (int a = 0; a < blocks; ++a) {
    for (int j = 0; j < blocks; ++j) {
      if (a != j) pairs.set_transport(a, j, random_matrix<double, block_dim, block_dim>(random));
    }
  }
  const auto products = std::make_unique<Products>();
  const auto normal = std::make_unique<NormalEquations<double, normal_dim, blocks>>();
  normal->reset(blocks);
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(dim, dim);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(dim);
  for (const int anchor : {2, 0, 4, 1}) {
    products->reset();
    for (int l = 0; l < 3; ++l) {
      add_landmark<1>(random, anchor, pairs, *products, H, b);
      add_landmark<4>(random, anchor, pairs, *products, H, b);
    }
    products->subtract_from(*normal, anchor, pairs);
    REQUIRE(relative_error(symmetric(normal->H()), H) < 1e-14);
    REQUIRE(relative_error(normal->b(), b) < 1e-14);
  }
  products->reset();
  products->subtract_from(*normal, 3, pairs);  // of none
  REQUIRE(relative_error(symmetric(normal->H()), H) < 1e-14);
}
