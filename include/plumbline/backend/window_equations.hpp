#pragma once
/// Normal equations of the states of a window, landmarks eliminated.                         docs/math/window.md
///
/// Visual rows depend on the camera poses T_k T_body_cam. With E = Ad(T_body_cam) an increment e of the extrinsics
/// moves all cameras as the increment E e of all bodies, so rows with the Jacobians J_k by the poses have J_e = (sum_k
/// J_k) E, and
///   H_ek = E^T sum_j H_jk,   H_ee = E^T (sum_jk H_jk) E,   b_e = E^T sum_k b_k                                 (6)
/// computed from the visual rows before anything else is added. The extrinsics thus add no work per landmark. The time
/// offset is in the rows of factors alone.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "plumbline/backend/extrinsics_prior.hpp"
#include "plumbline/backend/time_offset_prior.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/solver/anchored_products.hpp"
#include "plumbline/solver/normal_equations.hpp"
#include "plumbline/solver/relative_equations.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

template <class Window>
struct WindowEquations {
  using Layout = typename Window::Layout;
  using Rig = RigLayout<Layout>;
  /// Index of the block of the rig, after those of the frames.
  static constexpr int slots = Window::slots, rig = slots;
  using Normal = NormalEquations<double, Layout::dim, slots + (has_extrinsics<Layout> ? 1 : 0)>;
  using Pose = Mat<double, state::Pose::dim, state::Pose::dim>;

  Normal normal;
  RelativeEquations<double, state::Pose::dim, slots> pairs;    ///< of visual rows, which depend on poses alone
  AnchoredProducts<double, state::Pose::dim, slots> products;  ///< of the elimination of the landmarks of one anchor
  typename Normal::Vector step;

  /// Order of elimination: velocities and biases from the newest frame to the oldest, each of which shares a factor
  /// with the next one alone; then the rig, then the poses. The newest pose is last, so that its covariance is obtained
  /// from the last block of the Cholesky factor.
  void order(const Window& window) {
    std::array<int, slots> by_age;  // free slots, then oldest first
    for (int k = 0; k < slots; ++k) by_age[k] = k;
    const auto age = [&](int k) { return window[k].used ? std::int64_t(window[k].sequence) : -1; };
    std::sort(by_age.begin(), by_age.end(), [&](int a, int b) { return age(a) < age(b); });
    typename Normal::Order order;
    int n = 0;
    for (int c = Rig::dim; Rig::dim > 0 && c < Layout::dim; ++c) order[n++] = at(rig, c);
    for (int k = slots - 1; k >= 0; --k) {
      for (int c = state::Pose::dim; c < Layout::dim; ++c) order[n++] = at(by_age[k], c);
    }
    for (int c = 0; c < Rig::dim; ++c) order[n++] = at(rig, c);
    for (const int slot : by_age) {
      for (int c = 0; c < state::Pose::dim; ++c) order[n++] = at(slot, c);
    }
    normal.set_order(order);
  }

  void begin() { normal.reset(Normal::max_blocks); }

  /// Adds the rows and columns (6) of what was added so far, E at the first estimate of the extrinsics.
  void add_extrinsics(const Window& window) {
    if constexpr (has_extrinsics<Layout>) {
      if (!window.estimates_extrinsics()) return;
      const Pose E = window.extrinsics().first_estimate().template cast<double>().adjoint();
      Pose of_all = zeros<Pose>();
      for (int k = 0; k < slots; ++k) {
        Pose of_frame = zeros<Pose>();
        for (int j = 0; j < slots; ++j) {
          for (int c = 0; c < state::Pose::dim; ++c) {
            for (int r = 0; r < state::Pose::dim; ++r) {
              const int row = at(j, r), column = at(k, c);
              of_frame(r, c) += row > column ? normal.H()(row, column) : normal.H()(column, row);
            }
          }
        }
        normal.add_block(rig, k, Pose(E.transpose() * of_frame));
        of_all += of_frame;
      }
      normal.add_block(rig, rig, Pose(E.transpose() * of_all * E));
      Vec<double, state::Pose::dim> b = zeros<double, state::Pose::dim>();
      for (int k = 0; k < slots; ++k) {
        for (int c = 0; c < state::Pose::dim; ++c) b[c] += normal.b()[at(k, c)];
      }
      normal.add_gradient(rig, Vec<double, state::Pose::dim>(E.transpose() * b));
    }
  }
  /// Adds the prior on the extrinsics.
  void add_extrinsics(const Window& window, const ExtrinsicsPrior& prior) {
    if (window.estimates_extrinsics()) prior.add_to(cast_to<double>(window.extrinsics().correction()), rig, normal);
  }

  /// Adds the prior on the time offset.
  void add_time_offset(const Window& window, const TimeOffsetPrior& prior) {
    if (!window.estimates_time_offset()) return;
    const double e = window.time_offset().correction()[0], information = prior.information(e);
    add_offset(information, information * e);
  }

  /// Adds the prior, the rows of the factors, and an identity for every parameter without rows.
  void add_priors_and_factors(const Window& window, const auto& prior, const auto& factors) {
    prior.add_to(window, normal);
    for (int k = 0; k < slots; ++k) {
      fix(k, !window[k].used ? 0 : factors.active() ? Layout::dim : state::Pose::dim);
    }
    if constexpr (has_extrinsics<Layout>) fix_rig(window);
    factors.for_each_row(window, -1,
                         [&](int i, const auto& J_i, int j, const auto& J_j, const auto& J_offset, const auto& r) {
                           normal.add(i, J_i, j, J_j, r, 1.0);
                           if (!window.estimates_time_offset()) return;
                           const auto J_d = cast_to<double>(J_offset);
                           add_offset_and_frame(J_d, i, J_i);
                           add_offset_and_frame(J_d, j, J_j);
                           add_offset(squared_norm(J_d), dot(J_d, cast_to<double>(r)));
                         });
  }

  /// Adds the rows of the factors of single frames.
  void add_frame_factors(const Window& window, const auto& frame_factors) {
    frame_factors.for_each_row(window, -1,
                               [&](int slot, const auto& J, const auto& r) { normal.add(slot, J, r, 1.0); });
  }

  /// Marginal covariance of the leading blocks of the frame in `slot`, its pose first; false when it is not defined.
  template <class S, int Dim>
  bool covariance(int slot, Mat<S, Dim, Dim>& out) const {
    static_assert(Dim <= Layout::dim);
    Mat<double, Layout::dim, Layout::dim> block;
    if (!normal.covariance_block(slot, block)) return false;
    for (int c = 0; c < Dim; ++c) {
      for (int r = 0; r < Dim; ++r) out(r, c) = S(block(r, c));
    }
    return true;
  }

  /// Covariance of T_i_j, the pose of the frame in slot j in that of slot i, right increment; false when it is not
  /// defined.                                                                                    docs/math/map.md (6)
  template <class S>
  bool relative_covariance(const Window& window, int i, int j, Mat<S, state::Pose::dim, state::Pose::dim>& out) const {
    constexpr int dim = state::Pose::dim;
    Mat<double, 2 * dim, 2 * dim> joint;
    if (!normal.joint_covariance(std::array<int, 2>{i, j}, joint)) return false;
    const SE3<double> T_j_i = (window.T_world_body(j).inverse() * window.T_world_body(i)).template cast<double>();
    Mat<double, dim, 2 * dim> J = zeros<double, dim, 2 * dim>();
    set_block(J, 0, 0, Pose(-T_j_i.adjoint()));
    for (int k = 0; k < dim; ++k) J(k, dim + k) = 1;
    out = cast_to<S>(Pose(J * joint * J.transpose()));
    return all_finite(out);
  }

  /// Standard deviation of the time offset [s]; false when it is not defined.
  bool sigma_of_time_offset(double& sigma_s) const {
    Mat<double, Layout::dim, Layout::dim> block;
    if (!normal.covariance_block(rig, block)) return false;
    sigma_s = std::sqrt(block(offset, offset));
    return true;
  }

 private:
  /// Index of the time offset in the block of the rig.
  static constexpr int offset = [] {
    if constexpr (has_time_offset<Layout>) return Rig::template offset<state::TimeOffset>;
    return 0;
  }();

  /// Adds information on the time offset, and its gradient.
  void add_offset(double information, double gradient) {
    Mat<double, Rig::dim, Rig::dim> H = zeros<double, Rig::dim, Rig::dim>();
    Vec<double, Rig::dim> g = zeros<double, Rig::dim>();
    H(offset, offset) = information;
    g[offset] = gradient;
    normal.add_block(rig, rig, H);
    normal.add_gradient(rig, g);
  }
  /// Adds the block of rows between the time offset and a frame.
  template <class T, int Rows>
  void add_offset_and_frame(const Vec<double, Rows>& J_offset, int slot, const Mat<T, Rows, Layout::dim>& J) {
    Mat<double, Rig::dim, Layout::dim> H = zeros<double, Rig::dim, Layout::dim>();
    for (int c = 0; c < Layout::dim; ++c) {
      for (int k = 0; k < Rows; ++k) H(offset, c) += J_offset[k] * double(J(k, c));
    }
    normal.add_block(rig, slot, H);
  }

  /// Index of parameter c of a block.
  static std::int16_t at(int block, int c) { return std::int16_t(block * Layout::dim + c); }

  /// Adds an identity for the blocks of the rig that are not estimated.
  void fix_rig(const Window& window) {
    fix(rig, Rig::dim);
    Vec<double, Rig::dim> held = zeros<double, Rig::dim>();
    const auto fix_range = [&](int first, int count) {
      for (int k = first; k < first + count; ++k) held[k] = 1;
    };
    if (!window.estimates_extrinsics()) fix_range(Rig::template offset<state::Extrinsics>, state::Extrinsics::dim);
    if (!window.estimates_time_offset()) fix_range(offset, state::TimeOffset::dim);
    normal.add_block(rig, rig, Mat<double, Rig::dim, Rig::dim>(held.asDiagonal()));
  }

  /// Adds an identity for the parameters of a block from `first` on.
  void fix(int block, int first) {
    if (first == Layout::dim) return;
    Mat<double, Layout::dim, Layout::dim> H;
    set_zero(H);
    for (int c = first; c < Layout::dim; ++c) H(c, c) = 1;
    normal.add_block(block, block, H);
  }
};

}  // namespace plumbline
