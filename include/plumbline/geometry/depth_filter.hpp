#pragma once
/// The inverse depth of one point from many measurements some of which are wrong: a Gaussian for its value times a Beta
/// distribution for the share of measurements that mean it.                                  docs/math/direct.md
///
///   p(x | lambda, pi) = pi N(x; lambda, tau^2) + (1 - pi) U(x; range Z)                                      (12)
///   S  = sigma^2 + tau^2,   s2 = (1/sigma^2 + 1/tau^2)^-1,   m = s2 (mu/sigma^2 + x/tau^2)
///   C1 = a/(a+b) N(x; mu, S),   C2 = b/(a+b)/Z,   normalized to C1 + C2 = 1
///   mu' = C1 m + C2 mu,   sigma'^2 = C1 (s2 + m^2) + C2 (sigma^2 + mu^2) - mu'^2                              (13)
///   f = C1 (a+1)/(a+b+1) + C2 a/(a+b+1)
///   e = C1 (a+1)(a+2)/((a+b+1)(a+b+2)) + C2 a(a+1)/((a+b+1)(a+b+2))
///   a' = (e - f)/(f - e/f),   b' = a' (1 - f)/f                                                              (14)
/// These are the first two moments of the posterior of both, exactly.

#include <cmath>
#include <concepts>

#include "plumbline/core/elementary.hpp"

namespace plumbline {

template <std::floating_point S>
struct DepthFilter {
  S mu = S(0), variance = S(0);  ///< of the inverse depth [1/m]
  S a = S(10), b = S(10);        ///< inliers and outliers of the Beta distribution
  S range = S(0);                ///< Z, of all inverse depths there are [1/m]; 0: nothing is known

  /// Anything between 0 and twice `mu`, nearly.
  static DepthFilter around(S mu) {
    DepthFilter out;
    out.mu = mu;
    out.range = 3 * mu;
    out.variance = out.range / 6 * (out.range / 6);
    return out;
  }
  bool known() const { return range > S(0); }

  S sigma() const { return std::sqrt(variance); }
  /// Share of the measurements that mean the point.
  S inlier_share() const { return a / (a + b); }

  /// A measurement x with standard deviation tau. Counts against the point where it cannot be explained at all. Returns
  /// the gain: by how much of (x - mu) the mean moved.
  S update(S x, S tau) {
    const S tau2 = tau * tau, sum = variance + tau2, n = a + b;
    const S density = elementary::exp(-(x - mu) * (x - mu) / (2 * sum)) / std::sqrt(2 * pi * sum);
    S C1 = a / n * density, C2 = b / n / range;
    const S norm = C1 + C2;
    if (!(norm > S(0)) || !std::isfinite(norm)) {
      miss();
      return S(0);
    }
    C1 /= norm;
    C2 /= norm;
    const S gain = C1 * variance / sum;
    const S s2 = variance * tau2 / sum, m = (mu * tau2 + x * variance) / sum;
    const S mean = C1 * m + C2 * mu;  // (13), about the mean: no difference of large squares
    const S spread = C1 * (s2 + (m - mean) * (m - mean)) + C2 * (variance + (mu - mean) * (mu - mean));
    const S f = C1 * (a + 1) / (n + 1) + C2 * a / (n + 1);
    const S e = (C1 * (a + 2) + C2 * a) * (a + 1) / ((n + 1) * (n + 2));
    const S inliers = (e - f) / (f - e / f);  // (14)
    mu = mean;
    variance = spread;
    b = inliers * (1 - f) / f;
    a = inliers;
    return gain;
  }
  /// Looked for inside the image, and not found.
  void miss() { b += 1; }

  /// Known to `relative`, and most measurements meant it.
  bool converged(S relative) const { return mu > S(0) && sigma() < relative * mu && inlier_share() > S(0.5); }
  /// Most measurements meant something else, or it is behind the camera.
  bool diverged() const { return !(mu > S(0)) || inlier_share() < S(0.25); }

 private:
  static constexpr S pi = S(3.14159265358979323846);
};

}  // namespace plumbline
