#pragma once
/// The normal equations of a window's frames, landmarks eliminated.                             docs/math/window.md

#include <algorithm>
#include <array>
#include <cstdint>

#include "plumbline/core/matrix.hpp"
#include "plumbline/solver/normal_equations.hpp"
#include "plumbline/solver/relative_equations.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

template <class Window>
struct WindowEquations {
  using Layout = typename Window::Layout;
  static constexpr int slots = Window::slots;
  using Normal = NormalEquations<double, Layout::dim, slots>;

  Normal normal;
  RelativeEquations<double, state::Pose::dim, slots> pairs;  ///< of what is seen: features see poses alone
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
    for (int k = slots - 1; k >= 0; --k) {
      for (int c = state::Pose::dim; c < Layout::dim; ++c) order[n++] = std::int16_t(by_age[k] * Layout::dim + c);
    }
    for (const int slot : by_age) {
      for (int c = 0; c < state::Pose::dim; ++c) order[n++] = std::int16_t(slot * Layout::dim + c);
    }
    normal.set_order(order);
  }

  /// The prior, the rows of the links, and an identity for every parameter that nothing speaks of.
  void begin(const Window& window, const auto& prior, const auto& links) {
    prior.begin(window, normal);
    for (int k = 0; k < slots; ++k) {
      const int first = !window[k].used ? 0 : links.active() ? Layout::dim : state::Pose::dim;
      if (first == Layout::dim) continue;
      Mat<double, Layout::dim, Layout::dim> H;
      H.setZero();
      for (int c = first; c < Layout::dim; ++c) H(c, c) = 1;
      normal.add_block(k, k, H);
    }
    links.for_each_row(window, -1, [&](int i, const auto& J_i, int j, const auto& J_j, const auto& r) {
      normal.add(i, J_i, j, J_j, r, 1.0);
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
};

}  // namespace plumbline
