#pragma once
/// One small patch in the alignment of two whole images: what it looked like in the previous one and how its
/// intensities change with the motion of the body.                                        docs/math/direct.md
///
///   r_j = I_k(u' + D_j) - (1 + a) I_j - b,   I_j = I_{k-1}(u + D_j),   gain a and bias b of the frame          (1)
///   J_j = [(1 + a) g_j M, -I_j, -1],         M = du/d(dphi, dp),   g_j gradient of I_j                         (2)
/// M is the same for all samples of a patch, so that its normal equations are those of four numbers a sample,
///   sum J_j^T J_j = C^T (sum q_j q_j^T) C,   q_j = (g_j, -I_j, -1),   C = [(1 + a) M 0 0; 0 1 0; 0 0 1]        (3)

#include <cmath>
#include <cstdint>

#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/image/patch.hpp"

namespace plumbline {

/// M of (2) [px/rad, px/m]: how the pixel of a point at p_body moves when the body does, by [dphi, dp] of
/// T_cur_prev [+] d.  M = J_pi R_cam_prev [-[p]x, I],  R_cam_prev = R_cam_body R of the increment, R = I for motions of
/// the previous image's content.
template <class S>
Mat<S, 2, 6> motion_jacobian(const Mat<S, 2, 3>& J_uv_p, const Mat<S, 3, 3>& R_cam_prev, const Vec<S, 3>& p_body) {
  const Mat<S, 2, 3> by_position = product(J_uv_p, R_cam_prev);
  Mat<S, 2, 6> M;
  for (int k = 0; k < 2; ++k) {
    const S x = by_position(k, 0), y = by_position(k, 1), z = by_position(k, 2);
    M.row(k) << p_body.y() * z - p_body.z() * y, p_body.z() * x - p_body.x() * z, p_body.x() * y - p_body.y() * x, x, y,
        z;  // -row [p]x = p x row
  }
  return M;
}

struct AlignmentPatch {
  static constexpr int size = 4, samples = size * size;
  static constexpr int bordered_size = size + 2;  ///< with neighbors for the gradients

  bool valid = false;    ///< inside the previous image
  bool visible = false;  ///< and inside the current one
  Vec<float, samples> intensity = zeros<float, samples>();
  Vec<float, samples> gx = zeros<float, samples>();  ///< [intensity/px]
  Vec<float, samples> gy = zeros<float, samples>();
  Mat<float, 2, 6> M = zeros<float, 2, 6>();  ///< [px/rad, px/m] of the level
  Mat<float, 4, 4> Q = zeros<float, 4, 4>();  ///< sum q_j q_j^T of (3)
  Vec<float, 4> q_r = zeros<float, 4>();      ///< sum q_j r_j
  float error = 0;                            ///< root mean square of r_j [intensity]

  /// The samples around `center` [px of the level].
  void capture(const ImageView<const std::uint8_t>& image, const Vec<float, 2>& center) {
    valid = patch_inside(image, center, bordered_size);
    if (!valid) return;
    Patch<bordered_size> bordered;
    interpolate_patch<bordered_size>(image, center, bordered);
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) intensity[y * size + x] = bordered[(y + 1) * bordered_size + x + 1];
    }
    set_gradients(bordered);
  }

  /// Residuals (1) around `center` of the current image, and their sums. `forward`: gradients are the current image's.
  void compare(const ImageView<const std::uint8_t>& image, const Vec<float, 2>& center, float gain, float bias,
               bool forward) {
    visible = patch_inside(image, center, bordered_size);
    if (!visible) return;
    Vec<float, samples> r;
    if (forward) {
      Patch<bordered_size> bordered;
      interpolate_patch<bordered_size>(image, center, bordered);
      for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) r[y * size + x] = bordered[(y + 1) * bordered_size + x + 1];
      }
      set_gradients(bordered);
    } else {
      interpolate_patch<size>(image, center, r);
    }
    r -= (1 + gain) * intensity;
    r.array() -= bias;
    q_r << gx.dot(r), gy.dot(r), -intensity.dot(r), -r.sum();
    error = std::sqrt(r.squaredNorm() / float(samples));
  }

  /// Adds weight * (3), and the gradient, to equations of [dphi dp a b].
  template <class System>
  void add_to(System& system, float gain, float weight) const {
    const float w_M = weight * (1 + gain), w_MM = w_M * (1 + gain);
    for (int j = 0; j < 6; ++j) {
      const float gx_j = Q(0, 0) * M(0, j) + Q(0, 1) * M(1, j), gy_j = Q(1, 0) * M(0, j) + Q(1, 1) * M(1, j);
      for (int i = 0; i <= j; ++i) system.H(i, j) += w_MM * (M(0, i) * gx_j + M(1, i) * gy_j);
      for (int k = 0; k < 2; ++k) system.H(j, 6 + k) += w_M * (M(0, j) * Q(0, 2 + k) + M(1, j) * Q(1, 2 + k));
      system.b[j] += w_M * (M(0, j) * q_r[0] + M(1, j) * q_r[1]);
    }
    for (int k = 0; k < 2; ++k) {
      for (int i = 0; i <= k; ++i) system.H(6 + i, 6 + k) += weight * Q(2 + i, 2 + k);
      system.b[6 + k] += weight * q_r[2 + k];
    }
  }

 private:
  void set_gradients(const Patch<bordered_size>& bordered) {
    for (int y = 0; y < size; ++y) {
      const float* row = bordered.data() + (y + 1) * bordered_size + 1;
      for (int x = 0; x < size; ++x) {
        gx[y * size + x] = 0.5f * (row[x + 1] - row[x - 1]);
        gy[y * size + x] = 0.5f * (row[x + bordered_size] - row[x - bordered_size]);
      }
    }
    const float xx = gx.squaredNorm(), xy = gx.dot(gy), yy = gy.squaredNorm(), xi = -gx.dot(intensity),
                yi = -gy.dot(intensity), x1 = -gx.sum(), y1 = -gy.sum(), ii = intensity.squaredNorm(),
                i1 = intensity.sum();
    Q << xx, xy, xi, x1, xy, yy, yi, y1, xi, yi, ii, i1, x1, y1, i1, float(samples);
  }
};

}  // namespace plumbline
