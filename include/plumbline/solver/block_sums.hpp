#pragma once
/// Sums of blocks H_ij, i >= j, and of b_i, block by block in memory: what many landmarks add to a system of few
/// blocks.
///
/// NormalEquations holds one matrix, whose columns are far apart. Here a block is in one place, and products of a few
/// rows are added by the functions of solver/block_products.hpp.

#include <array>
#include <cstddef>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/solver/block_products.hpp"

namespace plumbline {

template <class A, int BlockDim, int MaxBlocks>
class BlockSums {
 public:
  using Block = Mat<A, BlockDim, BlockDim>;
  using Gradient = Vec<A, BlockDim>;
  template <std::size_t R>
  using Rows = std::array<Gradient, R>;

  /// Zero, for `blocks` active blocks.
  void reset(int blocks) {
    PLUMBLINE_ASSERT(blocks >= 0 && blocks <= MaxBlocks);
    blocks_ = blocks;
    for (int k = 0; k < index(blocks, 0); ++k) set_zero(H_[std::size_t(k)]);
    for (int i = 0; i < blocks; ++i) set_zero(b_[std::size_t(i)]);
  }
  Block& H(int i, int j) { return H_[std::size_t(index(i, j))]; }
  Gradient& b(int i) { return b_[std::size_t(i)]; }

  /// H_ij += sum_k a_k b_k^T in the lower triangle: H_ji += its transpose where i < j.
  template <std::size_t R>
  void add_product_of(int i, const Rows<R>& a, int j, const Rows<R>& b) {
    if (i >= j) {
      add_product(a, b, H(i, j));
    } else {
      add_product(b, a, H(j, i));
    }
  }

  template <class Normal>
  void add_to(Normal& normal) const {
    for (int i = 0; i < blocks_; ++i) {
      for (int j = 0; j <= i; ++j) normal.add_block(i, j, H_[std::size_t(index(i, j))]);
      normal.add_gradient(i, b_[std::size_t(i)]);
    }
  }

 private:
  static constexpr int index(int i, int j) { return i * (i + 1) / 2 + j; }

  int blocks_ = 0;
  std::array<Block, std::size_t(MaxBlocks) * (MaxBlocks + 1) / 2> H_;
  std::array<Gradient, std::size_t(MaxBlocks)> b_;
};

}  // namespace plumbline
