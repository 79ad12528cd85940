#pragma once
/// Rows that depend only on the relative pose of two blocks: a camera j that sees what camera a holds.
///                                                                                   docs/math/solver.md (9a)-(9c)
///   row   J (d_j - M_ja d_a) + r,  with one M_ja for all rows of the pair (a, j)                            (9a)
///   G_ja = sum J^T J,  g_ja = sum J^T r                                                                     (9b)
///   H_jj += G,  H_ja -= G M,  H_aa += M^T G M,  b_j += g,  b_a -= M^T g                                     (9c)
/// So a row is one Jacobian instead of two, (9b) is a quarter of its products, and M waits until the sums are complete.
/// A step that moves both blocks alike, d_j = M_ja d_a, changes nothing, whatever the rounding of the rows.
///
/// A row of block j alone has the anchor j.

#include <array>
#include <bitset>
#include <cstddef>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/solver/block_products.hpp"
#include "plumbline/solver/normal_equations.hpp"

namespace plumbline {

template <class S, int BlockDim, int MaxBlocks>
class RelativeEquations {
 public:
  using Scalar = S;
  using Block = Mat<S, BlockDim, BlockDim>;
  static constexpr int block_dim = BlockDim, max_blocks = MaxBlocks;

  /// No rows; the transports stay.
  void reset() { used_.reset(); }

  /// M_ja, a != j.
  const Block& transport(int a, int j) const { return M_[index(a, j)]; }
  void set_transport(int a, int j, const Block& M) { M_[index(a, j)] = M; }

  /// Steps d of all blocks as rows anchored in a see them, d_j - M_ja d_a; d_j begins `stride` numbers after d_(j-1).
  template <class D>
  auto steps(int a, const D& d, int stride) const {
    return [this, a, &d, stride, known = std::bitset<MaxBlocks>(),
            steps = std::array<Vec<S, BlockDim>, MaxBlocks>()](int j) mutable -> const Vec<S, BlockDim>& {
      if (known[j]) return steps[j];
      known[j] = true;
      const auto step_of = [&](int block) {
        Vec<S, BlockDim> out;
        for (int c = 0; c < BlockDim; ++c) out[c] = S(d[block * stride + c]);
        return out;
      };
      return steps[j] = step_of(j) - transport(a, j) * step_of(a);
    };
  }

  /// (9b) for R rows of BlockDim numbers, one after the other, and r.
  template <int R, class T>
  void add(int a, int j, const T* J, const T* r) {
    const std::size_t k = index(a, j);
    if (!used_[k]) {
      used_[k] = true;
      set_zero(G_[k]);
      set_zero(g_[k]);
    }
    std::array<Vec<S, BlockDim>, R> rows;
    for (int n = 0; n < R; ++n) {
      for (int c = 0; c < BlockDim; ++c) rows[n][c] = S(J[n * BlockDim + c]);
    }
    add_lower_product(rows, G_[k]);
    for (int n = 0; n < R; ++n) g_[k] += S(r[n]) * rows[n];
  }

  /// (9c)
  template <int NormalDim, int NormalBlocks>
  void add_to(NormalEquations<S, NormalDim, NormalBlocks>& normal) const {
    for (int a = 0; a < MaxBlocks; ++a) {
      for (int j = 0; j < MaxBlocks; ++j) {
        const std::size_t k = index(a, j);
        if (!used_[k]) continue;
        const Block G = symmetric_block(G_[k]);
        normal.add_block(j, j, G);
        normal.add_gradient(j, g_[k]);
        if (a == j) continue;
        const Block minus_M = -M_[k], GM = G * minus_M;
        if (j > a) {
          normal.add_block(j, a, GM);
        } else {
          normal.add_block(a, j, GM.transpose());
        }
        normal.add_block(a, a, Block(minus_M.transpose() * GM));
        normal.add_gradient(a, Vec<S, BlockDim>(minus_M.transpose() * g_[k]));
      }
    }
  }

 private:
  static constexpr std::size_t index(int a, int j) {
    PLUMBLINE_ASSERT(a >= 0 && a < MaxBlocks && j >= 0 && j < MaxBlocks);
    return std::size_t(a) * MaxBlocks + std::size_t(j);
  }

  std::bitset<std::size_t(MaxBlocks) * MaxBlocks> used_;
  std::array<Block, std::size_t(MaxBlocks) * MaxBlocks> G_, M_;  ///< of G the lower triangle
  std::array<Vec<S, BlockDim>, std::size_t(MaxBlocks) * MaxBlocks> g_;
};

}  // namespace plumbline
