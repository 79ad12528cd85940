#pragma once
/// Inverse-compositional alignment of one patch with gain and bias: the engine of optical flow and feature alignment.
///                                                                                         docs/math/tracking.md
///   I(u + D_j) = a T(D_j) + b,       unknown: position u, gain a, bias b                                       (3)
///   J = P grad T,  P = 1 - Q Q^T,    Q orthonormal basis of span{T, 1}: eliminates a and b exactly             (4)
///   u <- u - (J^T J)^-1 J^T I / a,   a = Tc . I / Tc . Tc,  Tc = T - mean(T)                                   (5)
/// J and J^T J are constant; one iteration is one interpolated patch and five dot products. Where T has no contrast the
/// gain cannot be separated from the bias: then Q = 1 / sqrt(n), a = 1 and J^T (I - T) takes the place of J^T I.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/image/patch.hpp"
#include "plumbline/image/patch_sums.hpp"

namespace plumbline {

/// Bounds of one search on one level.
struct PatchSearch {
  int max_iterations = 10;
  float epsilon_px = 0.01f;  ///< converged when a step is shorter [px of the level]
  float max_move_px = 4.0f;  ///< rejected farther from the start [px of the level]
};

struct PatchMatch {
  bool valid;        ///< center in the image, within max_move_px and converged
  Vec<float, 2> uv;  ///< [px of the level]
  float gain;        ///< a of (3)
  float rms;         ///< of I - a T - b over the patch [intensity]
};

template <int Size>
class PatchTemplate {
 public:
  static constexpr int bordered_size = Size + 2;
  using Bordered = Patch<bordered_size>;

  /// T with a border of one sample for the central differences.
  EIGEN_DONT_INLINE void set(const Bordered& bordered, bool with_gain = true) {
    const float* pixels = bordered.data();
    for (int y = 0; y < Size; ++y) {
      const float* row = pixels + (y + 1) * bordered_size + 1;
      float* T = T_.data() + y * Size;
      float* Jx = Jx_.data() + y * Size;
      float* Jy = Jy_.data() + y * Size;
      for (int x = 0; x < Size; ++x) {
        T[x] = row[x];
        Jx[x] = 0.5f * (row[x + 1] - row[x - 1]);
        Jy[x] = 0.5f * (row[x + bordered_size] - row[x - bordered_size]);
      }
    }
    subtract(mean_of(T_), T_);
    subtract(mean_of(Jx_), Jx_);
    subtract(mean_of(Jy_), Jy_);
    contrast_ = sum_of_squares(T_);
    JtT_ << sum_of_products(Jx_, T_), sum_of_products(Jy_, T_);
    has_gain_ = with_gain && contrast_ > min_variance * samples;
    if (has_gain_) {
      const float x = JtT_.x() / contrast_, y = JtT_.y() / contrast_;
      for (int k = 0; k < Size * Size; ++k) {  // (4)
        Jx_[k] -= x * T_[k];
        Jy_[k] -= y * T_[k];
      }
      set_zero(JtT_);
    }
    const float xy = sum_of_products(Jx_, Jy_);
    JtJ_ << sum_of_squares(Jx_), xy, xy, sum_of_squares(Jy_);
  }

  /// J^T J of the position after the elimination of gain and bias [intensity^2/px^2].
  const Mat<float, 2, 2>& information() const { return JtJ_; }

  /// Smallest eigenvalue of J^T J / n [intensity^2/px^2].
  float min_eigenvalue() const {
    const float mean = 0.5f * (JtJ_(0, 0) + JtJ_(1, 1)), half_gap = 0.5f * (JtJ_(0, 0) - JtJ_(1, 1));
    return (mean - std::sqrt(half_gap * half_gap + JtJ_(0, 1) * JtJ_(0, 1))) / samples;
  }

  /// Both components of the position; needs min_eigenvalue() > 0.
  PatchMatch search(const ImageView<const std::uint8_t>& image, const Vec<float, 2>& start,
                    const PatchSearch& bounds) const {
    const float det = JtJ_(0, 0) * JtJ_(1, 1) - JtJ_(0, 1) * JtJ_(1, 0);
    Mat<float, 2, 2> inverse;
    inverse << JtJ_(1, 1), -JtJ_(0, 1), -JtJ_(1, 0), JtJ_(0, 0);
    return iterate(image, start, inverse / det, bounds);
  }

  /// The component along the unit direction n alone; needs n^T J^T J n > 0.
  PatchMatch search_along(const ImageView<const std::uint8_t>& image, const Vec<float, 2>& start,
                          const Vec<float, 2>& n, const PatchSearch& bounds) const {
    const Mat<float, 2, 2> projector = n * n.transpose();
    return iterate(image, start, projector / dot(n, JtJ_ * n), bounds);
  }

 private:
  static void subtract(float mean, Patch<Size>& from) {
    for (int k = 0; k < Size * Size; ++k) from[k] -= mean;
  }

  static constexpr float samples = Size * Size;
  static constexpr float min_variance = 1.0f;               // contrast of quantization noise [intensity^2]
  static constexpr float min_gain = 0.5f, max_gain = 2.0f;  // of a step; the caller checks the final gain

  /// Steps u <- u - step_matrix J^T I / a.                                                                       (5)
  PatchMatch iterate(const ImageView<const std::uint8_t>& image, const Vec<float, 2>& start,
                     const Mat<float, 2, 2>& step_matrix, const PatchSearch& bounds) const {
    PatchMatch match{false, start, 1.0f, 0.0f};
    Patch<Size> I;
    for (int i = 0; i < bounds.max_iterations; ++i) {
      if (!image.contains(match.uv.x(), match.uv.y(), 0.0f)) return match;
      interpolate_patch<Size>(image, match.uv, I);
      const float TtI = sum_of_products(T_, I);
      if (has_gain_) match.gain = TtI / contrast_;
      const Vec<float, 2> gradient = Vec<float, 2>(sum_of_products(Jx_, I), sum_of_products(Jy_, I)) - JtT_;
      const Vec<float, 2> step = step_matrix * gradient / std::clamp(match.gain, min_gain, max_gain);
      match.uv -= step;
      if (!(squared_norm(match.uv - start) <= bounds.max_move_px * bounds.max_move_px)) return match;
      if (squared_norm(step) < bounds.epsilon_px * bounds.epsilon_px) {
        const float a = match.gain;
        const float squares = squared_norm_about(I, mean_of(I)) - 2 * a * TtI + a * a * contrast_;
        match.rms = std::sqrt(std::max(squares, 0.0f) / samples);
        match.valid = true;
        return match;
      }
    }
    return match;
  }

  Patch<Size> T_, Jx_, Jy_;  // T without its mean; J of (4)
  Vec<float, 2> JtT_;        // zero when the gain is eliminated
  Mat<float, 2, 2> JtJ_;
  float contrast_;  // Tc . Tc
  bool has_gain_;
};

}  // namespace plumbline
