#pragma once
/// Normal equations of ONE landmark and of the blocks that its rows touch.        docs/math/local_bundle_adjustment.md
/// (9)
///
///   H_ll, b_l of the landmark;  W_k = H_kl of every block k, column by column
/// `eliminate` leaves Y_k in the place of W_k.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/solver/block_sums.hpp"
#include "plumbline/solver/landmark_cholesky.hpp"

namespace plumbline {

template <class A, int Dim, int BlockDim, int MaxBlocks>
class LandmarkSystem {
 public:
  using Factor = LandmarkCholesky<A, Dim>;
  using Strip = std::array<Vec<A, BlockDim>, std::size_t(Dim)>;

  Mat<A, Dim, Dim> H;
  Vec<A, Dim> b;

  void reset() {
    set_zero(H);
    set_zero(b);
    count_ = 0;
    last_ = -1;
  }
  int blocks() const { return count_; }
  int block(int n) const { return block_[std::size_t(n)]; }
  const Strip& at(int n) const { return W_[std::size_t(n)]; }
  /// W of a block, zero at first. Fast where blocks come in their order.
  Strip& strip(int block) {
    PLUMBLINE_ASSERT(block >= 0 && block < MaxBlocks);
    if (block <= last_) {
      int n = count_ - 1;
      while (n >= 0 && block_[std::size_t(n)] != block) --n;
      if (n >= 0) return W_[std::size_t(n)];
    }
    last_ = std::max(last_, block);
    block_[std::size_t(count_)] = std::int16_t(block);
    set_zero(W_[std::size_t(count_)]);
    return W_[std::size_t(count_++)];
  }

  /// (8) and (9). False where the landmark has no factor; nothing is subtracted then.
  bool eliminate(A mu, Factor& factor, BlockSums<A, BlockDim, MaxBlocks>& sums) {
    if (!factor.factorize(H, b, mu)) return false;
    for (int n = 0; n < count_; ++n) {
      Strip& Y = W_[std::size_t(n)];
      factor.divide(Y);
      sums.b(block(n)) -= factor.times_c(Y);
      Strip minus_Y;
      for (std::size_t l = 0; l < std::size_t(Dim); ++l) minus_Y[l] = -Y[l];
      for (int m = 0; m <= n; ++m) sums.add_product_of(block(n), minus_Y, block(m), at(m));
    }
    return true;
  }

 private:
  int count_ = 0, last_ = -1;  ///< blocks, and the largest of them
  std::array<std::int16_t, std::size_t(MaxBlocks)> block_;
  std::array<Strip, std::size_t(MaxBlocks)> W_;
};

}  // namespace plumbline
