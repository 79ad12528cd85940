#pragma once
/// Robust kernels on s = |r|^2 of ONE whitened residual; the cost is 1/2 sum rho(s).      docs/math/solver.md (1)-(5)
///
///   weight(s) = rho'(s):   gradient J^T w r, Gauss-Newton Hessian J^T w J
///   second(s) = rho''(s):  the full one is J^T (w I + 2 rho'' r r^T) J
/// All have rho(0) = 0. A NaN stays a NaN, so that no solver accepts it.

#include <cmath>
#include <concepts>

#include "plumbline/core/elementary.hpp"

namespace plumbline {

template <class L>
concept RobustLoss = std::floating_point<typename L::Scalar> && requires(const L& loss, typename L::Scalar s) {
  { loss.rho(s) } -> std::same_as<typename L::Scalar>;
  { loss.weight(s) } -> std::same_as<typename L::Scalar>;
  { loss.second(s) } -> std::same_as<typename L::Scalar>;
};

/// Least squares.
template <class S>
struct NoLoss {
  using Scalar = S;
  S rho(S s) const { return s; }
  S weight(S) const { return S(1); }
  S second(S) const { return S(0); }
};

/// (1) Quadratic up to c sigma, linear beyond. 95 % efficient for one row; take sqrt(5.991) for two.
template <class S>
struct Huber {
  using Scalar = S;
  S c = S(1.345);
  S rho(S s) const { return s <= c * c ? s : 2 * c * std::sqrt(s) - c * c; }
  S weight(S s) const { return s <= c * c ? S(1) : c / std::sqrt(s); }
  S second(S s) const { return s <= c * c ? S(0) : -c / (2 * s * std::sqrt(s)); }

  template <int Rows>
  static constexpr Huber for_rows() {
    static_assert(Rows >= 1 && Rows <= 3);
    return {Rows == 1 ? S(1.345) : Rows == 2 ? S(2.45) : S(2.8)};  // sqrt(chi2_95) of two and three rows
  }
};

/// (2) Grows with the logarithm.
template <class S>
struct Cauchy {
  using Scalar = S;
  S c = S(2.385);
  S rho(S s) const { return c * c * elementary::log1p(s / (c * c)); }
  S weight(S s) const { return S(1) / (1 + s / (c * c)); }
  S second(S s) const { return -weight(s) * weight(s) / (c * c); }
};

/// (3) Outliers beyond c sigma have no weight at all: needs a good start.
template <class S>
struct Tukey {
  using Scalar = S;
  S c = S(4.685);
  S rho(S s) const { return s > c * c ? c * c / 3 : c * c / 3 * (1 - inside(s) * inside(s) * inside(s)); }
  S weight(S s) const { return s > c * c ? S(0) : inside(s) * inside(s); }
  S second(S s) const { return s > c * c ? S(0) : -2 * inside(s) / (c * c); }

 private:
  S inside(S s) const { return 1 - s / (c * c); }
};

/// (4) Negative log-likelihood of a t-distribution; small residuals weigh (nu + 1) / nu.
template <class S>
struct StudentT {
  using Scalar = S;
  S nu = S(5);
  S rho(S s) const { return (nu + 1) * elementary::log1p(s / nu); }
  S weight(S s) const { return (nu + 1) / (nu + s); }
  S second(S s) const { return -(nu + 1) / ((nu + s) * (nu + s)); }
};

/// (5) Bounded by k; a residual of s = k has a quarter of the weight.
template <class S>
struct GemanMcClure {
  using Scalar = S;
  S k = S(5.991);  // chi-square, 95 %, two rows
  S rho(S s) const { return k * s / (k + s); }
  S weight(S s) const { return k / (k + s) * (k / (k + s)); }
  S second(S s) const { return -2 * weight(s) / (k + s); }
};

/// The kernel for residuals of so many rows: with the width of its `for_rows<Rows>()`, or the default.
template <template <class> class Loss, class S, int Rows>
inline constexpr Loss<S> loss_for = [] {
  if constexpr (requires { Loss<S>::template for_rows<Rows>(); }) {
    return Loss<S>::template for_rows<Rows>();
  } else {
    return Loss<S>{};
  }
}();

static_assert(RobustLoss<NoLoss<float>> && RobustLoss<Huber<float>> && RobustLoss<Cauchy<double>>);
static_assert(RobustLoss<Tukey<float>> && RobustLoss<StudentT<float>> && RobustLoss<GemanMcClure<double>>);
static_assert(!RobustLoss<float>);

}  // namespace plumbline
