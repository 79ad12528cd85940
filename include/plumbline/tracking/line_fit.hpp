#pragma once
/// Lines through points of an image by total least squares, from running sums.              docs/math/line.md
///
///   mean = 1/n sum x_i,  C = 1/n sum x_i x_i^T - mean mean^T,  direction: eigenvector of the largest eigenvalue (19)
///   the smallest eigenvalue is the mean squared distance of the points to the line
/// Integer sums of pixels are exact. Float sums need an origin near the points.

#include <algorithm>
#include <cmath>

#include "plumbline/core/matrix.hpp"

namespace plumbline {

/// A line in the image.
struct FittedLine {
  Vec<float, 2> mean, direction;
  float variance;  ///< mean squared distance [px^2]
  float distance(const Vec<float, 2>& uv) const {
    const Vec<float, 2> d = uv - mean;
    return direction.x() * d.y() - direction.y() * d.x();
  }
  float along(const Vec<float, 2>& uv) const { return dot(direction, uv - mean); }
  Vec<float, 2> at(float along) const { return mean + along * direction; }
};

/// Sums over points, and the line of least squares through them.                                               (19)
template <class Number>
struct LineMoments {
  Number n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;

  void add(Number px, Number py, Number sign = 1) {
    n += sign;
    x += sign * px;
    y += sign * py;
    xx += sign * px * px;
    xy += sign * px * py;
    yy += sign * py * py;
  }

  /// The mean squared distance of the points to their line is at most `variance`: one eigenvalue of the covariance is.
  bool is_straight(float variance) const {
    const Covariance m = covariance();
    return m.xx <= variance || (m.xx - variance) * (m.yy - variance) <= m.xy * m.xy;
  }

  FittedLine line() const {
    const Covariance m = covariance();
    const float a = m.xx, b = m.xy, c = m.yy, count = static_cast<float>(n);
    const float half_gap = 0.5f * (a - c), root = std::sqrt(half_gap * half_gap + b * b);
    FittedLine out;
    out.mean << static_cast<float>(x) / count, static_cast<float>(y) / count;
    out.variance = std::max(0.0f, 0.5f * (a + c) - root);
    out.direction = half_gap > 0 ? Vec<float, 2>(half_gap + root, b) : Vec<float, 2>(b, root - half_gap);
    out.direction = normalized(out.direction);
    return out;
  }

 private:
  struct Covariance {
    float xx, xy, yy;
  };
  Covariance covariance() const {
    const float scale = 1.0f / (static_cast<float>(n) * static_cast<float>(n));
    return {static_cast<float>(n * xx - x * x) * scale, static_cast<float>(n * xy - x * y) * scale,
            static_cast<float>(n * yy - y * y) * scale};
  }
};

}  // namespace plumbline
