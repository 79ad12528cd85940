#pragma once
/// The depth of a segment from depths measured beside it.                                   docs/math/line.md
///
///   1/z = (1 - s) l_a + s l_b + c g       s in [0, 1] along the segment, c across it, on the plane z = 1:     (26)
///                                         exactly affine on a plane surface;  g ~ N(0, (slope (l_a + l_b)/2)^2)
///   Sigma = (sum [1-s, s]^T [1-s, s] / sigma^2 - h h^T / H_g)^-1  max(1, samples / independent_samples)       (27)
/// Inverse depth is what disparity sensors measure with constant noise; least squares of points in space would weigh
/// the far end wrongly. The surface beside an edge is not at its depth: on outward edges of a body both sides recede.
/// An edge often is where a near surface ends: it belongs to the NEARER of the two sides. They are separated as lines:
/// a single pair of samples does not show a step that all of them do.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/line3.hpp"

namespace plumbline {

/// An inverse depth measured at one place of a segment, or beside it.
template <class S>
struct LineDepthSample {
  S along;          ///< s of (26)
  S inverse_depth;  ///< 1/z [1/m]
  S sigma;          ///< [1/m]
  S across = S(0);  ///< c of (26)
};

struct LineDepthOptions {
  double inlier_sigmas = 3;
  double min_inliers = 0.6;          ///< share of the samples
  double min_extent = 0.5;           ///< of the segment between the outermost inliers
  double independent_samples = 8;    ///< neighboring pixels err together: more samples than these do not add up
  double max_relative_sigma = 0.05;  ///< of the inverse depth at both ends
  double slope = 1.7;                ///< of a surface, of (26): seen at 60 degrees
};

template <class S>
struct LineDepth {
  bool valid = false;
  Vec<S, 2> inverse_depth = zeros<S, 2>();     ///< l_a, l_b [1/m]
  Mat<S, 2, 2> covariance = zeros<S, 2, 2>();  ///< (27) [1/m^2]
  int inliers = 0;
};

/// s of (26) for a ray with z = 1 that looks at (or beside) the segment between two such rays.
template <class S>
S along_segment(const Vec<S, 3>& m, const Vec<S, 3>& m_start, const Vec<S, 3>& m_end) {
  const Vec<S, 3> extent = m_end - m_start;
  return dot(m - m_start, extent) / squared_norm(extent);
}

/// |c| of (26) for the same ray.
template <class S>
S across_segment(const Vec<S, 3>& m, const Vec<S, 3>& m_start, const Vec<S, 3>& m_end) {
  return norm(m - m_start - along_segment(m, m_start, m_end) * (m_end - m_start));
}

/// The line through both ends.
template <class S>
Line3<S> line_from_depth(const Vec<S, 3>& m_start, const Vec<S, 3>& m_end, const Vec<S, 2>& inverse_depth) {
  return Line3<S>::through(m_start / inverse_depth[0], m_end / inverse_depth[1]);
}

/// Of a positive definite matrix; not finite where it is singular.
template <class S>
Mat<S, 2, 2> inverse_of_symmetric(const Mat<S, 2, 2>& A) {
  const S det = A(0, 0) * A(1, 1) - A(0, 1) * A(0, 1);
  Mat<S, 2, 2> out;
  out << A(1, 1) / det, -A(0, 1) / det, -A(0, 1) / det, A(0, 0) / det;
  return out;
}

/// The affine function of s with the most inliers, then weighted least squares of these by (26). All samples are of one
/// side.
template <class S>
LineDepth<S> fit_line_depth(std::span<const LineDepthSample<S>> samples, const LineDepthOptions& options = {}) {
  constexpr std::size_t max_samples = 12;  // at most 66 pairs
  LineDepth<S> out;
  const std::size_t n = samples.size(), sampled = std::min(n, max_samples);
  S slope = 0;  // g of (26)
  const auto is_inlier = [&](const LineDepthSample<S>& x, const Vec<S, 2>& l) {
    const S expected = (1 - x.along) * l[0] + x.along * l[1] + x.across * slope;
    return std::abs(expected - x.inverse_depth) < S(options.inlier_sigmas) * x.sigma;
  };
  for (std::size_t i = 0; i < sampled; ++i) {
    for (std::size_t j = i + 1; j < sampled; ++j) {
      const LineDepthSample<S>&a = samples[i * n / sampled], &b = samples[j * n / sampled];
      const S change = (b.inverse_depth - a.inverse_depth) / (b.along - a.along);
      if (!(std::abs(b.along - a.along) > S(0.25))) continue;
      const S l_a = a.inverse_depth - change * a.along;
      const Vec<S, 2> l(l_a, l_a + change);
      const int inliers = static_cast<int>(
          std::count_if(samples.begin(), samples.end(), [&](const auto& x) { return is_inlier(x, l); }));
      if (inliers <= out.inliers) continue;
      out.inliers = inliers;
      out.inverse_depth = l;
    }
  }
  if (out.inliers < 3) return out;
  S first = 1, last = 0;
  for (int iteration = 0; iteration < 2; ++iteration) {
    Mat<S, 2, 2> H = zeros<S, 2, 2>();
    Vec<S, 2> b = zeros<S, 2>(), h = zeros<S, 2>();
    const S sigma_g = S(options.slope) * out.inverse_depth.sum() / 2;
    S H_g = 1 / (sigma_g * sigma_g), b_g = 0;
    out.inliers = 0;
    first = 1, last = 0;
    for (const LineDepthSample<S>& x : samples) {
      if (!is_inlier(x, out.inverse_depth)) continue;
      const Vec<S, 2> row(1 - x.along, x.along);
      const S weight = 1 / (x.sigma * x.sigma);
      H += weight * row * row.transpose();
      b += weight * x.inverse_depth * row;
      h += weight * x.across * row;
      H_g += weight * x.across * x.across;
      b_g += weight * x.across * x.inverse_depth;
      ++out.inliers;
      first = std::min(first, x.along);
      last = std::max(last, x.along);
    }
    out.covariance = inverse_of_symmetric<S>(H - h * h.transpose() / H_g);
    out.inverse_depth = out.covariance * (b - h * (b_g / H_g));
    slope = (b_g - dot(h, out.inverse_depth)) / H_g;
  }
  out.covariance *= std::max(S(1), S(out.inliers) / S(options.independent_samples));  // (27)
  const Vec<S, 2> sigma = out.covariance.diagonal().cwiseSqrt();
  out.valid = S(out.inliers) >= S(options.min_inliers) * S(n) && last - first >= S(options.min_extent) &&
              sigma[0] < S(options.max_relative_sigma) * out.inverse_depth[0] &&  // false for NaN too
              sigma[1] < S(options.max_relative_sigma) * out.inverse_depth[1];
  return out;
}

/// The line of both sides of an edge: of both together where they agree, else of the nearer one; and of one alone where
/// the other is not valid.
///   d = l_1 - l_2,   d^T (Sigma_1 + Sigma_2)^-1 d < max_chi2                                                (27a)
/// One surface taken for two costs a fraction of a sigma; two taken for one cost half of what lies between them, and
/// always the same way.
template <class S>
LineDepth<S> nearer_side(const LineDepth<S>& one, const LineDepth<S>& other, S max_chi2 = S(1)) {
  if (!one.valid || !other.valid) return one.valid ? one : other;
  const Vec<S, 2> d = one.inverse_depth - other.inverse_depth;
  const Mat<S, 2, 2> W = inverse_of_symmetric<S>(one.covariance + other.covariance);
  const Vec<S, 2> W_d = W * d;
  if (!(dot(d, W_d) < max_chi2)) return d.sum() > S(0) ? one : other;
  LineDepth<S> both = one;
  both.inverse_depth -= one.covariance * W_d;
  both.covariance = one.covariance * W * other.covariance;
  both.inliers += other.inliers;
  return both;
}

}  // namespace plumbline
