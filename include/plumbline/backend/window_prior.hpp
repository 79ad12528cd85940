#pragma once
/// Marginalization prior of a window: r0 + J0 e, e the corrections of its frames and of the rig.
///                                                                                           docs/math/window.md
///
/// J0 has columns for every slot (backend/prior_columns.hpp); those of free slots, and of frames without prior
/// information, are zero.

#include <algorithm>
#include <cmath>
#include <tuple>

#include "plumbline/backend/prior_columns.hpp"
#include "plumbline/core/assert.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/present.hpp"
#include "plumbline/feature/readout_derivatives.hpp"
#include "plumbline/feature/window_views.hpp"
#include "plumbline/solver/marginalization.hpp"
#include "plumbline/solver/normal_equations.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

/// `max_rows`, `max_columns`: largest numbers of rows and parameters of one landmark; `rolls`: the shutter is rolling.
template <class Window, int max_rows, int max_columns, bool rolls = false>
class WindowPrior {
 public:
  using Columns = PriorColumns<Window, rolls>;
  using Vector = typename Columns::Vector;
  static constexpr int frame_dim = Columns::frame_dim, at_readout = Columns::at_readout, dim = Columns::dim;

  WindowPrior() { H_.resize(dim, dim); }

  /// Prior on the readout time, from the next `set` on [s]; sigma 0: it is not estimated.
  void set_readout_prior(double value_s, double sigma_s) { readout_prior_ = {value_s, sigma_s}; }
  /// Readout time in use [s].
  void set_readout(double value_s) { readout_s_ = value_s; }

  /// Replaces the prior by whitened rows J on one frame, zero at its present state, and the prior on the readout time.
  template <int Rows>
  void set(Window& window, int slot, const Mat<double, Rows, frame_dim>& J) {
    const bool finds_readout = rolls && readout_prior_.sigma_s > 0;
    prior_.J0.resize(Rows + finds_readout, dim);
    set_zero(prior_.J0);
    for (int c = 0; c < frame_dim; ++c) {
      for (int k = 0; k < Rows; ++k) prior_.J0(k, slot * frame_dim + c) = J(k, c);
    }
    prior_.r0.resize(Rows + finds_readout);
    set_zero(prior_.r0);
    if (finds_readout) {
      prior_.J0(Rows, at_readout) = 1 / readout_prior_.sigma_s;
      prior_.r0[Rows] = -readout_prior_.value_s / readout_prior_.sigma_s;
    }
    prior_.information(H_);
    window.state(slot).fix_first_estimates();
  }

  /// Adds one whitened row on two frames; r is the residual at their present states.
  void add(Window& window, int i, const Mat<double, 1, frame_dim>& J_i, int j, const Mat<double, 1, frame_dim>& J_j,
           double r) {
    const int row = int(prior_.J0.rows());
    PLUMBLINE_ASSERT(row < dim);
    reduced_.J0 = prior_.J0;
    reduced_.r0 = prior_.r0;
    prior_.J0.resize(row + 1, dim);
    prior_.r0.resize(row + 1);
    for (int c = 0; c < dim; ++c) {
      for (int k = 0; k < row; ++k) prior_.J0(k, c) = reduced_.J0(k, c);
      prior_.J0(row, c) = 0;
    }
    for (int k = 0; k < row; ++k) prior_.r0[k] = reduced_.r0[k];
    for (const int slot : {i, j}) window.state(slot).fix_first_estimates();
    const Vector e = corrections(window);
    for (int c = 0; c < frame_dim; ++c) {
      prior_.J0(row, i * frame_dim + c) = J_i(0, c);
      prior_.J0(row, j * frame_dim + c) = J_j(0, c);
      r -= J_i(0, c) * e[i * frame_dim + c] + J_j(0, c) * e[j * frame_dim + c];  // at e = 0
    }
    prior_.r0[row] = r;
    prior_.information(H_);
  }

  /// Adds a measured distance between two frames, with its sigma [m].                       docs/math/window.md (5)
  ///   d|p_j - p_i| = u^T (R_j dp_j - R_i dp_i),  u = (p_j - p_i)/|p_j - p_i|
  void add_distance(Window& window, int i, int j, double distance, double sigma) {
    using S = typename Window::Scalar;
    const SE3<S>&T_i = window.T_world_body(i), &T_j = window.T_world_body(j);
    const Vec<S, 3> p = T_j.p() - T_i.p(), u = normalized(p);
    const Vec<S, 3> u_i = T_i.rotation().inverse() * u, u_j = T_j.rotation().inverse() * u;
    Mat<double, 1, frame_dim> J_i, J_j;
    set_zero(J_i);
    set_zero(J_j);
    constexpr int position = 3;  // of the pose's increment
    for (int k = 0; k < 3; ++k) {
      J_i(0, position + k) = -double(u_i[k]) / sigma;
      J_j(0, position + k) = double(u_j[k]) / sigma;
    }
    add(window, i, J_i, j, J_j, (double(norm(p)) - distance) / sigma);
  }

  double cost(const Window& window) const { return prior_.residual(corrections(window)).squaredNorm() / 2; }

  template <class Equations>
  void add_to(const Window& window, Equations& equations) const {
    equations.add(H_.topLeftCorner(at_readout, at_readout));
    equations.add_gradient(prior_.gradient(prior_.residual(corrections(window))).head(at_readout));
  }
  /// Adds the rows of the prior to the column of the readout time, and to its information and gradient.
  void add_readout_to(const Window& window, auto& column, ReadoutBorder& border) const requires rolls {
    for (int c = 0; c < at_readout; ++c) column[c] += H_(at_readout, c);
    border.information += H_(at_readout, at_readout);
    border.gradient += prior_.gradient(prior_.residual(corrections(window)))[at_readout];
  }

  // Marginalization of a frame: `begin_retirement`, then all rows that depend on it, then `retire`.

  void begin_retirement(const Window& window) {
    marginalizer_.reset(dim);
    marginalizer_.add_rows(prior_.J0, prior_.r0);
    e_ = corrections(window);
    if constexpr (has_extrinsics<typename Window::Layout>) {
      E_.set(window.estimates_extrinsics() ? window.extrinsics().first_estimate().template cast<double>().adjoint()
                                           : typename Columns::Adjoint(zeros<typename Columns::Adjoint>()));
    }
  }

  /// Adds whitened rows of a factor between two frames, at the current state; J_offset: by the time offset.
  template <class S, int Rows>
  void add_factor(int i, const Mat<S, Rows, frame_dim>& J_i, int j, const Mat<S, Rows, frame_dim>& J_j,
                  const Vec<S, Rows>& J_offset, const Vec<S, Rows>& r) {
    Vec<double, Rows> r0;
    for (int k = 0; k < Rows; ++k) {  // the prior's residual belongs to e = 0
      r0[k] = double(r[k]);
      for (int c = 0; c < frame_dim; ++c) {
        r0[k] -= double(J_i(k, c)) * e_[i * frame_dim + c] + double(J_j(k, c)) * e_[j * frame_dim + c];
      }
    }
    if constexpr (has_time_offset<typename Window::Layout>) {
      for (int k = 0; k < Rows; ++k) r0[k] -= double(J_offset[k]) * e_[Columns::at_time_offset];
      marginalizer_.add_rows(J_i, i * frame_dim, J_j, j * frame_dim, J_offset, Columns::at_time_offset, r0);
    } else {
      marginalizer_.add_rows(J_i, i * frame_dim, J_j, j * frame_dim, r0);
    }
  }

  /// Adds whitened rows of a factor of one frame, at the current state.
  template <class S, int Rows>
  void add_factor(int slot, const Mat<S, Rows, frame_dim>& J, const Vec<S, Rows>& r) {
    Vec<double, Rows> r0;
    for (int k = 0; k < Rows; ++k) {  // the prior's residual belongs to e = 0
      r0[k] = double(r[k]);
      for (int c = 0; c < frame_dim; ++c) r0[k] -= double(J(k, c)) * e_[slot * frame_dim + c];
    }
    marginalizer_.add_rows(J, r0, slot * frame_dim);
  }

  /// Adds the rows of one landmark, at the current state, and their derivatives by the readout time; the landmark is
  /// eliminated.
  template <class Landmark, class Pairs>
  void add_landmark(const Landmark& landmark, const Pairs& pairs, const auto& derivatives) {
    constexpr int columns = Landmark::landmark_dim;
    static_assert(columns <= max_columns && Landmark::max_rows <= max_rows);
    const int rows = landmark.rows();
    work_.resize(rows, columns + dim + 1);
    const int rank = landmark.reduced_rows(work_, pairs, frame_dim, [&] {
      for (int k = 0; rolls && k < rows; ++k) work_(k, columns + at_readout) = double(derivatives[k]);
    });
    if (rows <= rank) return;
    if constexpr (has_extrinsics<typename Window::Layout>) {
      for (int k = rank; k < rows; ++k) Columns::move_with_extrinsics(work_, k, columns, E_.get());
    }
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_rows, 1> r(rows - rank);
    for (int k = rank; k < rows; ++k) r[k - rank] = work_(k, columns + dim);
    for (int c = 0; c < dim; ++c) {  // the prior's residual belongs to e = 0
      for (int k = rank; k < rows; ++k) r[k - rank] -= work_(k, columns + c) * e_[c];
    }
    marginalizer_.add_rows(work_.block(rank, columns, rows - rank, dim), r);
  }

  /// Marginalizes the frame in `slot`. `readout_walk_s`: sigma of the change of the readout time since the last call
  /// [s].
  void retire(Window& window, int slot, double readout_walk_s = 0) {
    const int first = slot * frame_dim;
    if (marginalizer_.marginalize(first, frame_dim, reduced_)) {
      if constexpr (rolls) inflate_readout(readout_walk_s);
      prior_.widen(reduced_, first, frame_dim);
    } else {
      prior_.forget(first, frame_dim);
    }
    prior_.information(H_);
    window.remove(slot);
    for (int k = 0; k < Window::slots; ++k) {
      if (window[k].used && prior_.knows(k * frame_dim, frame_dim)) window.state(k).fix_first_estimates();
    }
  }

 private:
  /// Adds the walk to the variance 1/j^2 of the readout time, j the last row of the triangle: 1/j^2 <- 1/j^2 + walk^2.
  void inflate_readout(double walk_s) {
    const int last = reduced_.dim() - 1;
    const double j = reduced_.J0(last, last), less = 1 / std::sqrt(1 + walk_s * walk_s * j * j);
    reduced_.J0(last, last) *= less;
    reduced_.r0[last] *= less;
  }

  /// e at the present states.
  Vector corrections(const Window& window) const { return Columns::corrections(window, readout_s_); }

  struct ReadoutPrior {
    double value_s = 0, sigma_s = 0;
  };

  ReadoutPrior readout_prior_;
  double readout_s_ = 0;
  Prior<dim> prior_, reduced_;
  BoundedMatrix<double, dim, dim> H_;  ///< J0^T J0, constant until the next marginalization
  Marginalizer<dim, 64> marginalizer_;
  Vector e_;
  /// Ad(T_body_cam) at the first estimate, zero when not estimated.
  [[no_unique_address]] Present<typename Columns::Adjoint, has_extrinsics<typename Window::Layout>> E_;
  BoundedMatrix<double, max_rows, max_columns + dim + 1> work_;
};

namespace detail {

template <class Window, class Terms>
struct PriorOf;
template <class Window, class... T>
struct PriorOf<Window, std::tuple<T...>> {
  using Type = WindowPrior<Window, std::max({T::max_rows...}), std::max({T::Kind::dim...}), (T::Sensors::rolls || ...)>;
};

}  // namespace detail

/// Prior of a window with a tuple of terms, one for each kind.
template <class Window, class Terms>
using WindowPriorOf = typename detail::PriorOf<Window, Terms>::Type;

}  // namespace plumbline
