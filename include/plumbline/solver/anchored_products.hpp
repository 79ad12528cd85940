#pragma once
/// What all landmarks of one anchor a take from the normal equations when they are eliminated.
///                                                                                  docs/math/solver.md (11a)-(11b)
///   P_ij = sum A_i^T A_j,  p_i = sum A_i^T c   of the blocks that see them                                   (11a)
///   H_ij -= P_ij,  H_ia += sum_j P_ij M_ja,  H_aa -= sum_ij M_ia^T P_ij M_ja
///   b_i -= p_i,    b_a += sum_i M_ia^T p_i                                                                   (11b)
/// Their rows are relative (9a), so A_a = -sum_j A_j M_ja: the anchor's part of each product waits until the sums are
/// complete, as that of the rows themselves does in RelativeEquations.

#include <array>
#include <bitset>
#include <cstddef>

#include "plumbline/core/matrix.hpp"
#include "plumbline/solver/block_products.hpp"
#include "plumbline/solver/normal_equations.hpp"
#include "plumbline/solver/relative_equations.hpp"

namespace plumbline {

template <class S, int BlockDim, int MaxBlocks>
class AnchoredProducts {
 public:
  using Pairs = RelativeEquations<S, BlockDim, MaxBlocks>;
  using Block = typename Pairs::Block;

  void reset() { seen_.reset(); }

  /// (11a) of a landmark with R columns: A block by block, row by row, of those that are touched.
  template <std::size_t R>
  void add(const std::bitset<MaxBlocks>& touched, const std::array<std::array<Vec<S, BlockDim>, R>, MaxBlocks>& A,
           const Vec<S, int(R)>& c) {
    std::array<int, MaxBlocks> blocks;
    int n = 0;
    for (int i = 0; i < MaxBlocks; ++i) {
      if (touched[i]) blocks[n++] = i;
    }
    for (int k = 0; k < n; ++k) {
      const int i = blocks[k];
      if (!seen_[i]) begin(i);
      Vec<S, BlockDim> sum = c[0] * A[i][0];
      for (int l = 1; l < int(R); ++l) sum += c[l] * A[i][l];
      p_[i] += sum;
      for (int m = 0; m < k; ++m) add_product(A[i], A[blocks[m]], P_[index(i, blocks[m])]);
      add_lower_product(A[i], P_[index(i, i)]);
    }
  }

  /// (11b)
  template <int NormalDim, int NormalBlocks>
  void subtract_from(NormalEquations<S, NormalDim, NormalBlocks>& normal, int anchor, const Pairs& pairs) {
    for (int i = 0; i < MaxBlocks; ++i) {
      if (seen_[i]) P_[index(i, i)] = symmetric_block(P_[index(i, i)]);
    }
    for (int i = 0; i < MaxBlocks; ++i) {
      if (!seen_[i]) continue;
      Block PM;
      set_zero(PM);
      for (int j = 0; j < MaxBlocks; ++j) {
        if (!seen_[j]) continue;
        const Block P = j <= i ? P_[index(i, j)] : Block(P_[index(j, i)].transpose());
        if (j <= i) normal.add_block(i, j, Block(-P));
        add_product(P, pairs.transport(anchor, j), PM);
      }
      if (i > anchor) {
        normal.add_block(i, anchor, PM);
      } else {
        normal.add_block(anchor, i, PM.transpose());
      }
      const Block minus_M = -pairs.transport(anchor, i);
      normal.add_block(anchor, anchor, Block(minus_M.transpose() * PM));
      normal.add_gradient(i, Vec<S, BlockDim>(-p_[i]));
      normal.add_gradient(anchor, Vec<S, BlockDim>(pairs.transport(anchor, i).transpose() * p_[i]));
    }
  }

 private:
  /// Of i >= j.
  static constexpr std::size_t index(int i, int j) {
    return std::size_t(i) * (std::size_t(i) + 1) / 2 + std::size_t(j);
  }

  /// Block i is seen for the first time.
  void begin(int i) {
    seen_[i] = true;
    set_zero(p_[i]);
    for (int j = 0; j < MaxBlocks; ++j) {
      if (seen_[j]) set_zero(P_[j < i ? index(i, j) : index(j, i)]);
    }
  }

  std::bitset<MaxBlocks> seen_;
  std::array<Block, std::size_t(MaxBlocks) * (MaxBlocks + 1) / 2> P_;  ///< lower triangle; zero where not both are seen
  std::array<Vec<S, BlockDim>, MaxBlocks> p_;
};

}  // namespace plumbline
