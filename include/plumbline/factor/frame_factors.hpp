#pragma once
/// The factors of the frames of a window: each is attached to a slot.                          docs/math/factors.md
///
///   FrameFactors<F, Slots>       factors of one type, at most Slots of them
///   FrameFactorList<Slots, F...> of several types
///   NoFrameFactors               of none: no memory, no code
/// A frame may have several factors of a type. They live as long as the frame keeps its slot.

#include <concepts>
#include <cstddef>
#include <tuple>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/factor/factor.hpp"

namespace plumbline {

template <Factor F, int Slots>
class FrameFactors {
 public:
  /// False, and nothing attached, when as many factors as the window has slots are attached already.
  bool insert(int slot, const F& factor) { return attached_.push_back({slot, factor}); }
  /// Removes the factors of a frame.
  void remove(int slot) {
    for (std::size_t k = attached_.size(); k-- > 0;) {
      if (attached_[k].slot == slot) attached_.swap_remove(k);
    }
  }
  void clear() { attached_.clear(); }
  int size() const { return int(attached_.size()); }

  /// Linearizes the factors of `slot`, or all for -1, and calls take(slot, J, r) with their whitened rows. J has a
  /// column for each parameter of the frame; r is at its value, J at its first estimate.
  template <class Window>
  void for_each_row(const Window& window, int slot, auto&& take) const {
    for (const Attached& attached : attached_) {
      if (slot >= 0 && attached.slot != slot) continue;
      const auto& state = window[attached.slot].state;
      const auto linearized = attached.factor.linearize(state.value(), state.first_estimate());
      if (linearized.valid) take(attached.slot, by_frame<typename Window::Layout, F>(linearized.J_r_x), linearized.r);
    }
  }
  /// The same, of factors that are marginalized with their frame.
  void for_each_marginalized_row(const auto& window, int slot, auto&& take) const {
    if constexpr (F::is_marginalized) for_each_row(window, slot, take);
  }

  /// Sum of |r|^2 / 2.
  double cost(const auto& window) const {
    double sum = 0;
    for (const Attached& attached : attached_) {
      const Vec<typename F::Scalar, F::dim> r = attached.factor.residual(window[attached.slot].state.value());
      sum += double(squared_norm(r)) / 2;
    }
    return sum;
  }

 private:
  struct Attached {
    int slot;
    F factor;
  };
  FixedVector<Attached, std::size_t(Slots)> attached_;
};

template <int Slots, Factor... F>
class FrameFactorList {
 public:
  template <class G>
  static constexpr bool takes = (false || ... || std::same_as<F, G>);

  template <class G>
  bool insert(int slot, const G& factor) requires takes<G> {
    return std::get<FrameFactors<G, Slots>>(stores_).insert(slot, factor);
  }
  void remove(int slot) {
    for_each([&](auto& factors) { factors.remove(slot); });
  }
  void clear() {
    for_each([](auto& factors) { factors.clear(); });
  }
  void for_each_row(const auto& window, int slot, auto&& take) const {
    (store<F>().for_each_row(window, slot, take), ...);
  }
  void for_each_marginalized_row(const auto& window, int slot, auto&& take) const {
    (store<F>().for_each_marginalized_row(window, slot, take), ...);
  }
  double cost(const auto& window) const { return (0.0 + ... + store<F>().cost(window)); }

 private:
  template <class G>
  const FrameFactors<G, Slots>& store() const {
    return std::get<FrameFactors<G, Slots>>(stores_);
  }
  void for_each(auto&& visit) { (visit(std::get<FrameFactors<F, Slots>>(stores_)), ...); }

  std::tuple<FrameFactors<F, Slots>...> stores_;
};

struct NoFrameFactors {
  template <class G>
  static constexpr bool takes = false;
  static void remove(int /*slot*/) {}
  static void clear() {}
  static void for_each_row(const auto& /*window*/, int /*slot*/, auto&& /*take*/) {}
  static void for_each_marginalized_row(const auto& /*window*/, int /*slot*/, auto&& /*take*/) {}
  static constexpr double cost(const auto& /*window*/) { return 0; }
};

namespace detail {
template <class S, int Slots, template <class> class... F>
struct FrameFactorsOf {
  using Type = FrameFactorList<Slots, F<S>...>;
};
template <class S, int Slots>
struct FrameFactorsOf<S, Slots> {
  using Type = NoFrameFactors;
};
}  // namespace detail

/// The store for the factor templates F, each with the scalar S.
template <class S, int Slots, template <class> class... F>
using FrameFactorsOf = typename detail::FrameFactorsOf<S, Slots, F...>::Type;

}  // namespace plumbline
