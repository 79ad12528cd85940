#pragma once
/// Normal equations of a pose graph and their Cholesky factor, in memory linear in nodes.    docs/math/pose_graph.md
///
///   (H + mu D) d = -b,  H = sum w J^T J,  b = sum w J^T r,  D = clip(diag H, 1e-6, 1e6)                     (14)
/// A node k between two loop ends couples to its successor and to the last loop end a before it alone. Eliminated:
///   L_k L_k^T = H_kk + mu D_k,  U_k = H_(k+1)k L_k^-T,  V_k = H_ak L_k^-T,  y_k = L_k^-1 b_k                (15)
///   H_(k+1)(k+1) -= U U^T,  H_a(k+1) -= V U^T,  H_aa -= V V^T,  b_(k+1) -= U y,  b_a -= V y                 (16)
/// What is left couples loop ends only, and is factorized by blocks in the order of map/loop_ends.hpp:
///   L_pq = (H_pq - sum_k L_pk L_qk^T) L_qq^-T,  y_p = L_pp^-1 (b_p - sum_q L_pq y_q)                        (17)
///   d_p = -L_pp^-T (y_p + sum_k L_kp^T d_k),  d_k = -L_k^-T (y_k + U_k^T d_(k+1) + V_k^T d_a)               (18)
///   predicted decrease = 1/2 (mu d.D d - d.b) = 1/2 (sum mu d.D d + sum |y|^2)                              (19)
///
/// A call does the work of one edge, row or node, so that the caller can divide a solution into slices. Their order is
/// reset, add_loop (all), add_odometry (k = 1, 2, ...), factorize_row (p = 0, 1, ...), solve_end (p = ..., 1, 0),
/// step (k = ..., 2, 1). They return false where H + mu D is not positive definite, or not finite.

#include <algorithm>
#include <array>
#include <cstddef>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/map/loop_ends.hpp"
#include "plumbline/solver/block_cholesky.hpp"
#include "plumbline/solver/normal_equations.hpp"

namespace plumbline {

template <class S, int Dim, int MaxNodes, int MaxLoops>
class PoseGraphEquations {
 public:
  using Scalar = S;
  using Block = Mat<S, Dim, Dim>;
  using Vector = Vec<S, Dim>;
  using Ends = LoopEnds<MaxNodes, MaxLoops>;

  /// The structure, as LoopEnds::find takes it.
  template <class EndsOf>
  void set_structure(int nodes, int loops, EndsOf&& ends_of) {
    ends_.find(nodes, loops, ends_of);
  }
  int ends() const { return ends_.count(); }

  /// No rows; for the damping mu.
  void reset(S mu) {
    mu_ = mu;
    doubled_decrease_ = S(0);
    end_before_ = Ends::none;
    current_.reset();
    for (int p = 0; p < ends(); ++p) {
      end(p).reset();
      for (int q = 0; q < p; ++q) {
        if (ends_.has_block(p, q)) set_zero(block(p, q));
      }
    }
  }

  /// Whitened rows of a loop between nodes i and j.
  void add_loop(int i, int j, const Block& J_i, const Block& J_j, const Vector& r, S weight) {
    const int p = ends_.position(i), q = ends_.position(j);
    if (p != Ends::none) end(p).add(J_i, r, weight);
    if (q != Ends::none) end(q).add(J_j, r, weight);
    if (p == Ends::none || q == Ends::none) return;  // the first node does not move
    if (p > q) {
      add_transposed_product(block(p, q), J_i, J_j, weight);
    } else {
      add_transposed_product(block(q, p), J_j, J_i, weight);
    }
  }

  /// Whitened rows of the odometry from node k - 1 to k. Node k - 1 is then complete: unless it is a loop end, it is
  /// eliminated.
  bool add_odometry(int k, const Block& J_before, const Block& J_k, const Vector& r) {
    Block H_k_before = zeros<Block>();
    add_transposed_product(H_k_before, J_k, J_before, S(1));
    Equations next;
    next.reset();
    next.add(J_k, r, S(1));
    if (ends_.is_end(k - 1)) {
      end_before_ = ends_.position(k - 1);
      end(end_before_).add(J_before, r, S(1));
      transpose(H_k_before, H_end_current_);
    } else if (k > 1) {
      current_.add(J_before, r, S(1));
      if (!eliminate(node_[std::size_t(k - 1)], H_k_before, next)) return false;
    }
    if (!ends_.is_end(k)) {
      current_ = next;
      return true;
    }
    const int p = ends_.position(k);
    end(p).add(next);
    if (end_before_ == Ends::none) return true;
    if (end_before_ > p) {
      block(end_before_, p) += H_end_current_;
    } else {
      Block transposed;
      transpose(H_end_current_, transposed);
      block(p, end_before_) += transposed;
    }
    return true;
  }

  /// Row p of (17).
  bool factorize_row(int p) {
    Equations& row = end(p);
    for (int q = 0; q < p; ++q) {
      if (!ends_.has_block(p, q)) continue;
      Block& L_pq = block(p, q);
      for (int k = 0; k < q; ++k) {
        if (ends_.has_block(p, k) && ends_.has_block(q, k)) subtract_product(L_pq, block(p, k), block(q, k));
      }
      divide_block(L_pq, end(q).H);
      subtract_product(row.H, L_pq, L_pq);
      subtract_product(row.b, L_pq, end(q).b);
    }
    return row.factorize(mu_);
  }

  /// The step of loop end p, (18). It takes the place of y_p.
  void solve_end(int p) {
    Vector& y = end(p).b;
    doubled_decrease_ += squared_norm(y);
    for (int n = 0; n < Dim; ++n) y[n] = -y[n];
    for (int k = p + 1; k < ends(); ++k) {
      if (ends_.has_block(k, p)) subtract_transposed_product(y, block(k, p), end(k).b);
    }
    solve_upper(end(p).H, y);
    doubled_decrease_ += end(p).damping_of(y, mu_);
  }
  /// The step of node k, (18).
  const Vector& step(int k) {
    if (ends_.is_end(k)) return step_ = end(ends_.position(k)).b;
    const Node& node = node_[std::size_t(k)];
    Vector d;
    for (int n = 0; n < Dim; ++n) d[n] = -node.eliminated.b[n];
    subtract_transposed_product(d, node.U, step_);
    if (node.end != Ends::none) subtract_transposed_product(d, node.V, end(node.end).b);
    solve_upper(node.eliminated.H, d);
    doubled_decrease_ += squared_norm(node.eliminated.b) + node.eliminated.damping_of(d, mu_);
    return step_ = d;
  }
  /// (19), after the last step.
  S predicted_decrease() const { return doubled_decrease_ / 2; }

  /// Covariance of the newest node: it is eliminated last. After all rows are factorized with mu = 0.
  Block newest_covariance() const { return inverse_of_factored(ends_of_loops_[std::size_t(ends() - 1)].H); }

 private:
  /// The equations of one node; when it is factorized L and y stand in the place of H and b.
  struct Equations {
    Block H;
    Vector b, diagonal;  ///< diagonal of H before anything is eliminated

    void reset() {
      set_zero(H);
      set_zero(b);
      set_zero(diagonal);
    }
    void add(const Block& J, const Vector& r, S weight) {
      Block JtJ = zeros<Block>();
      add_transposed_product(JtJ, J, J, weight);
      H += JtJ;
      for (int n = 0; n < Dim; ++n) diagonal[n] += JtJ(n, n);
      add_transposed_product(b, J, r, weight);
    }
    void add(const Equations& other) {
      H += other.H;
      b += other.b;
      diagonal += other.diagonal;
    }
    bool factorize(S mu) {
      for (int n = 0; n < Dim; ++n) H(n, n) += mu * damping_scale(diagonal[n]);
      if (!factorize_block(H, diagonal)) return false;
      solve_lower(H, b);
      return true;
    }
    /// mu d.D d
    S damping_of(const Vector& d, S mu) const {
      S sum = S(0);
      for (int n = 0; n < Dim; ++n) sum += mu * damping_scale(diagonal[n]) * d[n] * d[n];
      return sum;
    }
  };
  struct Node {
    Equations eliminated;
    Block U, V;  ///< (15)
    int end;     ///< the loop end of V, or none
  };

  Equations& end(int p) { return ends_of_loops_[std::size_t(p)]; }
  /// Block (p, q), q < p, over the loop ends.
  Block& block(int p, int q) {
    PLUMBLINE_ASSERT(q < p);
    return blocks_[std::size_t(p) * std::size_t(p - 1) / 2 + std::size_t(q)];
  }
  static void transpose(const Block& A, Block& out) {
    for (int c = 0; c < Dim; ++c) {
      for (int r = 0; r < Dim; ++r) out(c, r) = A(r, c);
    }
  }

  /// (15), (16) of the current node; `next` are the equations of its successor.
  bool eliminate(Node& node, const Block& H_next_current, Equations& next) {
    node.eliminated = current_;
    node.end = end_before_;
    if (!node.eliminated.factorize(mu_)) return false;
    node.U = H_next_current;
    divide_block(node.U, node.eliminated.H);
    subtract_product(next.H, node.U, node.U);
    subtract_product(next.b, node.U, node.eliminated.b);
    if (end_before_ == Ends::none) return true;
    node.V = H_end_current_;
    divide_block(node.V, node.eliminated.H);
    set_zero(H_end_current_);
    subtract_product(H_end_current_, node.V, node.U);
    subtract_product(end(end_before_).H, node.V, node.V);
    subtract_product(end(end_before_).b, node.V, node.eliminated.b);
    return true;
  }

  Ends ends_;
  S mu_ = S(0), doubled_decrease_ = S(0);
  Equations current_;    ///< of the node between loop ends that was added last
  Block H_end_current_;  ///< its coupling to the last loop end before it
  int end_before_ = Ends::none;
  Vector step_;  ///< of the node solved for last
  std::array<Node, std::size_t(MaxNodes)> node_;
  std::array<Equations, std::size_t(Ends::max_ends)> ends_of_loops_;
  std::array<Block, std::max(std::size_t(1), std::size_t(Ends::max_ends) * (Ends::max_ends - 1) / 2)> blocks_;
};

}  // namespace plumbline
