#pragma once
/// Points on lines of a bundle adjustment.                           docs/math/local_bundle_adjustment.md (15)-(17)
///
///   r = distance of the point to its line by its range / sigma, residual/collinear_world_point.hpp           (15)
///   B = sum w J_l^T J_p,  C = sum w J_p^T J_c   of the rows by line, point, and center of the camera
///   Y_l = B L_p^-T;   H_ll -= Y_l Y_l^T,  b_l -= Y_l c,  W_kl -= Y_k Y_l^T                                   (16)
///   what a member adds to sum W^T d of its point:  B^T d_l + C dp_k                                          (17)
/// A point is eliminated from the poses and from its one line, before the line is. The camera that its range is from is
/// that of its first observation.

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>

#include "plumbline/core/matrix.hpp"
#include "plumbline/map/bundle_lines.hpp"
#include "plumbline/residual/collinear_world_point.hpp"
#include "plumbline/solver/block_cholesky.hpp"

namespace plumbline {

template <std::floating_point S, int MaxKeyframes, int MaxPoints, int MaxLines>
class BundleMembers {
 public:
  using Keyframes = BundleKeyframes<S, MaxKeyframes>;
  using Lines = BundleLines<S, MaxKeyframes, MaxLines>;
  using Sums = typename Lines::Sums;
  using Losses = BundleLosses<S>;
  static constexpr int none = -1;

  /// A point is new: on no line.
  void reset(int point) {
    if constexpr (MaxLines > 0) member_[std::size_t(point)].line = none;
  }
  bool has(int point) const {
    if constexpr (MaxLines > 0) return member_[std::size_t(point)].line != none;
    return false;
  }
  /// `keyframe`: the one of the point's first observation.
  bool add(int line, int point, S sigma, int keyframe, const Keyframes& keyframes, Lines& lines) {
    const S per_sigma = S(1) / sigma;
    if (!lines.has(line) || has(point) || !(sigma > S(0)) || !std::isfinite(per_sigma * per_sigma)) return false;
    Member& member = member_[std::size_t(point)];
    member.line = line;
    member.keyframe = keyframe;
    member.per_sigma = per_sigma;
    lines.anchor(line, keyframes.state(keyframe).T_map_cam.p());
    return true;
  }

  /// One that is not valid at the start (a point in the center of the camera) is left out.
  void begin(int point, const Vec<S, 3>& p_map, const Keyframes& keyframes, const Lines& lines) {
    if (has(point)) member_[std::size_t(point)].is_used = linearize(point, p_map, keyframes, lines).valid;
  }
  /// The rows of a member, before its point is eliminated.
  template <class PointSystem>
  void add_rows(int p, const Vec<S, 3>& p_map, const Keyframes& keyframes, const Losses& losses, PointSystem& point,
                Lines& lines, Sums& sums) {
    Member& member = member_[std::size_t(p)];
    set_zero(member.B);
    set_zero(member.C);
    if (!member.is_used) return;
    const auto lin = linearize(p, p_map, keyframes, lines);
    if (!lin.valid) return;
    const S squared = squared_norm(lin.r) * member.per_sigma * member.per_sigma, w = losses.two_rows.weight(squared);
    const double weight = double(member.per_sigma) * double(member.per_sigma) * double(w);
    const Mat<double, 2, 3> J_p = cast_to<double>(lin.J_r_point), J_c = cast_to<double>(lin.J_r_center);
    const Mat<double, 2, 4> J_l = cast_to<double>(lin.J_r_line);
    const Vec<double, 2> r = cast_to<double>(lin.r);
    auto& line = lines.system(member.line);
    add_transposed_product(point.H, J_p, J_p, weight);
    add_transposed_product(point.b, J_p, r, weight);
    add_transposed_product(line.H, J_l, J_l, weight);
    add_transposed_product(line.b, J_l, r, weight);
    add_products(member.B, J_l, J_p, weight);
    const int block = keyframes.block(member.keyframe);
    if (block == none) return;
    Mat<double, 2, 6> J_k = zeros<double, 2, 6>();
    set_block(J_k, 0, 3, J_c);
    add_transposed_product(member.C, J_p, J_c, weight);
    add_transposed_product(sums.H(block, block), J_k, J_k, weight);
    add_transposed_product(sums.b(block), J_k, r, weight);
    add_products(point.strip(block), J_k, J_p, weight);
    add_products(line.strip(block), J_k, J_l, weight);
  }
  /// (16), after its point was eliminated.
  template <class PointSystem>
  void take_over(int p, const PointSystem& point, const typename PointSystem::Factor& factor, Lines& lines) {
    const Member& member = member_[std::size_t(p)];
    auto& line = lines.system(member.line);
    auto Y = member.B;
    factor.divide(Y);
    line.b -= factor.times_c(Y);
    for (const Vec<double, 4>& y : Y) {
      for (int m = 0; m < 4; ++m) {
        for (int n = 0; n < 4; ++n) line.H(n, m) -= y[n] * y[m];
      }
    }
    for (int n = 0; n < point.blocks(); ++n) {
      typename Lines::System::Strip& W = line.strip(point.block(n));
      for (int m = 0; m < 4; ++m) {
        for (std::size_t c = 0; c < 3; ++c) W[std::size_t(m)] -= Y[c][m] * point.at(n)[c];
      }
    }
  }
  /// (17)
  Vec<double, 3> by_line_and_pose(int p, const Keyframes& keyframes, const Lines& lines) const {
    const Member& member = member_[std::size_t(p)];
    const int block = keyframes.block(member.keyframe);
    Vec<double, 3> out = zeros<double, 3>();
    if (block != none) out = member.C * segment<3>(keyframes.step(block), 3);
    for (int c = 0; c < 3; ++c) out[c] += dot(member.B[std::size_t(c)], lines.line(member.line).step);
    return out;
  }

  /// At the state or the trial, where the point is `p_map`.
  double cost(int p, const Vec<S, 3>& p_map, bool is_trial, const Keyframes& keyframes, const Losses& losses,
              const Lines& lines) const {
    const Member& member = member_[std::size_t(p)];
    if (!member.is_used) return 0;
    const auto& line = lines.line(member.line);
    const auto& keyframe = is_trial ? keyframes.trial(member.keyframe) : keyframes.state(member.keyframe);
    const Vec<S, 2> r = CollinearWorldPoint<S>::residual(is_trial ? line.trial : line.state, p_map - line.origin,
                                                         keyframe.T_map_cam.p() - line.origin);
    return double(losses.two_rows.rho(squared_norm(r) * member.per_sigma * member.per_sigma)) / 2;
  }

 private:
  struct Member {
    int line, keyframe;
    S per_sigma;
    bool is_used = true;
    std::array<Vec<double, 4>, 3> B;  ///< column by column
    Mat<double, 3, 3> C;
  };

  typename CollinearWorldPoint<S>::Linearized linearize(int p, const Vec<S, 3>& p_map, const Keyframes& keyframes,
                                                        const Lines& lines) const {
    const Member& member = member_[std::size_t(p)];
    const auto& line = lines.line(member.line);
    return CollinearWorldPoint<S>::linearize(line.state, p_map - line.origin,
                                             keyframes.state(member.keyframe).T_map_cam.p() - line.origin);
  }

  std::array<Member, std::size_t(MaxLines > 0 ? MaxPoints : 1)> member_;
};

}  // namespace plumbline
