#pragma once
/// R rows over all blocks at once, and over one landmark that is yet to be eliminated: what another landmark leaves
/// behind when it is.                                                                  docs/math/solver.md (13)

#include <array>
#include <bitset>
#include <cstddef>

#include "plumbline/core/matrix.hpp"

namespace plumbline {

template <class S, std::size_t R, int BlockDim, int MaxBlocks, int OtherDim>
struct BlockRows {
  std::bitset<MaxBlocks> touched;                                ///< blocks that J has values of
  std::array<std::array<Vec<S, BlockDim>, R>, MaxBlocks> J;      ///< block by block, row by row
  std::array<Vec<S, OtherDim>, R> J_other;                       ///< by the landmark
  std::array<S, R> r;

  /// H += J^T J, b += J^T r, the landmark being eliminated.
  template <class Normal>
  void add_to(Normal& normal) const {
    for (int i = 0; i < MaxBlocks; ++i) {
      if (!touched[i]) continue;
      Vec<S, BlockDim> g = r[0] * J[i][0];
      for (std::size_t k = 1; k < R; ++k) g += r[k] * J[i][k];
      normal.add_gradient(i, g);
      for (int j = 0; j <= i; ++j) {
        if (touched[j]) normal.add_product(i, J[i], j, J[j]);
      }
    }
  }
};

}  // namespace plumbline
