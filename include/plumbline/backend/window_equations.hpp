#pragma once
/// The normal equations of a window's frames, landmarks eliminated.                             docs/math/window.md
///
/// What is seen depends on where the camera is, T_k T_body_cam: with E = Ad(T_body_cam) a step e of the mount moves it
/// as the step E e of all bodies together would, so that rows J_k of the poses have J_e = (sum_k J_k) E, and
///   H_ek = E^T sum_j H_jk,   H_ee = E^T (sum_jk H_jk) E,   b_e = E^T sum_k b_k                                 (6)
/// of what is seen, before anything else is added. A landmark costs nothing more. The camera's clock is in links alone.

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
  static constexpr int slots = Window::slots, rig = slots;  ///< it is the block after those of the frames
  using Normal = NormalEquations<double, Layout::dim, slots + (has_extrinsics<Layout> ? 1 : 0)>;
  using Pose = Mat<double, state::Pose::dim, state::Pose::dim>;

  Normal normal;
  RelativeEquations<double, state::Pose::dim, slots> pairs;    ///< of what is seen: features see poses alone
  AnchoredProducts<double, state::Pose::dim, slots> products;  ///< what landmarks of one anchor take when eliminated
  typename Normal::Vector step;

  /// The order of elimination: velocities and biases from the newest to the oldest, each of which is linked to the next
  /// one alone, then the poses. The newest pose is last: its covariance is the end of the factor.
  void order(const Window& window) {
    std::array<int, slots> by_age;  // oldest first, those that are free before all
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

  /// (6), of what was added so far, E at the mount's first estimate.
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
  /// What was known of the mount.
  void add_extrinsics(const Window& window, const ExtrinsicsPrior& prior) {
    if (window.estimates_extrinsics()) prior.add_to(cast_to<double>(window.extrinsics().correction()), rig, normal);
  }

  /// What was known of the camera's clock.
  void add_time_offset(const Window& window, const TimeOffsetPrior& prior) {
    if (!window.estimates_time_offset()) return;
    const double e = window.time_offset().correction()[0], information = prior.information(e);
    add_clock(information, information * e);
  }

  /// The prior, the rows of the links, and an identity for every parameter that nothing speaks of.
  void add_known(const Window& window, const auto& prior, const auto& links) {
    prior.add_to(window, normal);
    for (int k = 0; k < slots; ++k) {
      hold(k, !window[k].used ? 0 : links.active() ? Layout::dim : state::Pose::dim);
    }
    if constexpr (has_extrinsics<Layout>) hold_rig(window);
    links.for_each_row(window, -1,
                       [&](int i, const auto& J_i, int j, const auto& J_j, const auto& J_clock, const auto& r) {
                         normal.add(i, J_i, j, J_j, r, 1.0);
                         if (!window.estimates_time_offset()) return;
                         const auto J_d = cast_to<double>(J_clock);
                         add_clock_and_frame(J_d, i, J_i);
                         add_clock_and_frame(J_d, j, J_j);
                         add_clock(squared_norm(J_d), dot(J_d, cast_to<double>(r)));
                       });
  }

  /// Of the leading blocks of the frame in `slot`, its pose first; false when it is not defined.
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

  /// The same of the camera's clock [s].
  bool sigma_of_time_offset(double& sigma_s) const {
    Mat<double, Layout::dim, Layout::dim> block;
    if (!normal.covariance_block(rig, block)) return false;
    sigma_s = std::sqrt(block(clock, clock));
    return true;
  }

 private:
  /// Of the block of the rig.
  static constexpr int clock = [] {
    if constexpr (has_time_offset<Layout>) return Rig::template offset<state::TimeOffset>;
    return 0;
  }();

  /// Information on the camera's clock, and its gradient.
  void add_clock(double information, double gradient) {
    Mat<double, Rig::dim, Rig::dim> H = zeros<double, Rig::dim, Rig::dim>();
    Vec<double, Rig::dim> g = zeros<double, Rig::dim>();
    H(clock, clock) = information;
    g[clock] = gradient;
    normal.add_block(rig, rig, H);
    normal.add_gradient(rig, g);
  }
  /// What the same rows say of it and of a frame.
  template <class T, int Rows>
  void add_clock_and_frame(const Vec<double, Rows>& J_clock, int slot, const Mat<T, Rows, Layout::dim>& J) {
    Mat<double, Rig::dim, Layout::dim> H = zeros<double, Rig::dim, Layout::dim>();
    for (int c = 0; c < Layout::dim; ++c) {
      for (int k = 0; k < Rows; ++k) H(clock, c) += J_clock[k] * double(J(k, c));
    }
    normal.add_block(rig, slot, H);
  }

  static std::int16_t at(int block, int c) { return std::int16_t(block * Layout::dim + c); }

  /// An identity for what is not estimated of the rig.
  void hold_rig(const Window& window) {
    hold(rig, Rig::dim);
    Vec<double, Rig::dim> held = zeros<double, Rig::dim>();
    const auto rest = [&](int first, int count) {
      for (int k = first; k < first + count; ++k) held[k] = 1;
    };
    if (!window.estimates_extrinsics()) rest(Rig::template offset<state::Extrinsics>, state::Extrinsics::dim);
    if (!window.estimates_time_offset()) rest(clock, state::TimeOffset::dim);
    normal.add_block(rig, rig, Mat<double, Rig::dim, Rig::dim>(held.asDiagonal()));
  }

  /// An identity for the parameters of a block from `first` on.
  void hold(int block, int first) {
    if (first == Layout::dim) return;
    Mat<double, Layout::dim, Layout::dim> H;
    set_zero(H);
    for (int c = first; c < Layout::dim; ++c) H(c, c) = 1;
    normal.add_block(block, block, H);
  }
};

}  // namespace plumbline
