#pragma once
/// One block of the state with its first estimate.                                           docs/math/window.md
///
/// A block that a prior refers to keeps its linearization point x0 and moves by a correction e, x = x0 [+] e
/// (first-estimate Jacobians): increments are added to e, Jacobians are taken at x0, and the prior is exactly r0 + J0
/// e. Before `fix_first_estimate` the linearization point moves with the value.

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/present.hpp"
#include "plumbline/lie/plus.hpp"

namespace plumbline {

template <class Block, class S>
class Estimated {
 public:
  using Value = typename Block::template Value<S>;
  using Step = Vec<S, Block::dim>;

  Estimated() : Estimated(detail::nothing<Value>()) {}
  explicit Estimated(const Value& value) : Estimated(value, value) {}
  Estimated(const Value& value, const Value& first) : value_(value), first_(first), e_(difference(value, first)) {}

  const Value& value() const { return value_; }
  /// x0: linearization point.
  const Value& first_estimate() const { return first_; }
  /// e: increment from the first estimate to the value.
  const Step& correction() const { return e_; }

  /// Moves the value by the increment d.
  void add(const Step& d) {
    if (fixed_) {
      e_ += d;
      value_ = moved(first_, e_);
    } else {
      *this = Estimated(moved(value_, d), moved(first_, d));
    }
  }
  /// Keeps the first estimate from now on, because a prior refers to it.
  void fix_first_estimate() { fixed_ = true; }
  bool is_fixed() const { return fixed_; }
  /// Value and first estimate of a pose in another world, x_new = T_new_old x_old; the correction stays.
  void transform(const SE3<S>& T_new_old) {
    value_ = T_new_old * value_;
    first_ = T_new_old * first_;
  }

 private:
  static SE3<S> moved(const SE3<S>& T, const Vec<S, 6>& d) { return plus(T, d); }
  static Step moved(const Step& x, const Step& d) { return x + d; }
  static Vec<S, 6> difference(const SE3<S>& a, const SE3<S>& b) { return minus(a, b); }
  static Step difference(const Step& a, const Step& b) { return a - b; }

  Value value_, first_;
  Step e_;
  bool fixed_ = false;
};

}  // namespace plumbline
