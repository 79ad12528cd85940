#pragma once
/// Keyframes of a bundle adjustment: poses, their trial, and the blocks of the free ones.
///                                                                          docs/math/local_bundle_adjustment.md (1)
///   T [+] d = plus(T, blkdiag(R^T, R^T) d),   d = [dphi; dp] in axes of the map                               (1)
/// In these axes a pose has the derivatives (4) of bearing_observation.hpp, without a rotation.

#include <array>
#include <concepts>
#include <cstddef>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/residual/world_point.hpp"

namespace plumbline {

/// A Jacobian by the right increment of a pose, as one by the increment of (1).
template <class S, int Rows>
Mat<double, Rows, 6> in_axes_of_map(const Mat<double, Rows, 6>& J_right, const SE3<S>& T_map_cam) {
  const Mat<double, 3, 3> R_cam_map = cast_to<double>(T_map_cam.rotation().inverse().matrix());
  Mat<double, Rows, 6> out;
  set_block(out, 0, 0, product(block<Rows, 3>(J_right, 0, 0), R_cam_map));
  set_block(out, 0, 3, product(block<Rows, 3>(J_right, 0, 3), R_cam_map));
  return out;
}

template <std::floating_point S, int MaxKeyframes>
class BundleKeyframes {
 public:
  static constexpr int none = -1, max_keyframes = MaxKeyframes;

  /// A camera pose with what is computed once for all that it sees.
  struct Keyframe {
    SE3<S> T_map_cam;
    BodyView<S> view;
    void set(const SE3<S>& T) {
      T_map_cam = T;
      view = BodyView<S>(T, SE3<S>());
    }
  };

  void clear() { count_ = 0; }
  int count() const { return count_; }
  bool has(int k) const { return k >= 0 && k < count_; }
  int add(const SE3<S>& T_map_cam, bool is_fixed) {
    if (count_ == MaxKeyframes || !T_map_cam.is_finite()) return none;
    state_[std::size_t(count_)].set(T_map_cam);
    is_fixed_[std::size_t(count_)] = is_fixed;
    return count_++;
  }

  /// Gives the free ones their blocks.
  void begin() {
    free_ = 0;
    for (int k = 0; k < count_; ++k) {
      trial_[std::size_t(k)] = state_[std::size_t(k)];
      block_[std::size_t(k)] = is_fixed_[std::size_t(k)] ? none : free_++;
    }
  }
  int free() const { return free_; }
  int block(int k) const { return block_[std::size_t(k)]; }
  const Keyframe& state(int k) const { return state_[std::size_t(k)]; }
  const Keyframe& trial(int k) const { return trial_[std::size_t(k)]; }

  /// d of all free keyframes, block by block.
  template <class D>
  void make_trial(const D& d) {
    for (int k = 0; k < count_; ++k) {
      const int block = block_[std::size_t(k)];
      if (block == none) continue;
      Vec<double, 6>& step = step_[std::size_t(block)];
      for (int n = 0; n < 6; ++n) step[n] = d[6 * block + n];
      const SE3<S>& T = state_[std::size_t(k)].T_map_cam;
      const SO3<S> R_cam_map = T.rotation().inverse();
      Vec<S, 6> right;
      set_segment(right, 0, R_cam_map * cast_to<S>(segment<3>(step, 0)));
      set_segment(right, 3, R_cam_map * cast_to<S>(segment<3>(step, 3)));
      trial_[std::size_t(k)].set(plus(T, right));
    }
  }
  const Vec<double, 6>& step(int block) const { return step_[std::size_t(block)]; }
  void accept() {
    for (int k = 0; k < count_; ++k) {
      if (block_[std::size_t(k)] != none) state_[std::size_t(k)] = trial_[std::size_t(k)];
    }
  }

 private:
  int count_ = 0, free_ = 0;
  std::array<Keyframe, std::size_t(MaxKeyframes)> state_, trial_;
  std::array<bool, std::size_t(MaxKeyframes)> is_fixed_;
  std::array<int, std::size_t(MaxKeyframes)> block_;
  std::array<Vec<double, 6>, std::size_t(MaxKeyframes)> step_;  ///< block by block
};

}  // namespace plumbline
