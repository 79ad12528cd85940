#pragma once
/// Points of a bundle adjustment and what keyframes observed of them.     docs/math/local_bundle_adjustment.md (4)-(7)
///
///   E = [ [a]x, -I ],  a = X - c;   H_pp = sum G,  b_p = sum g,  W_k = E^T G                                  (5)
///   H_kk = E^T G E,  b_k = E^T g;   W_k^T d_k = G (a x dphi_k - dp_k)                                     (6), (7)
/// A point has a few numbers of its own, each observation G of (3).

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/counting_sort.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/map/bearing_observation.hpp"
#include "plumbline/map/bundle_cost.hpp"
#include "plumbline/map/bundle_keyframes.hpp"
#include "plumbline/solver/landmark_system.hpp"

namespace plumbline {

template <std::floating_point S, int MaxKeyframes, int MaxPoints, int MaxObservations>
class BundlePoints {
 public:
  using Keyframes = BundleKeyframes<S, MaxKeyframes>;
  using System = LandmarkSystem<double, 3, 6, MaxKeyframes>;
  using Factor = typename System::Factor;
  using Sums = BlockSums<double, 6, MaxKeyframes>;
  using Losses = BundleLosses<S>;
  static constexpr int none = -1;

  void clear() { points_ = observations_ = 0; }
  int count() const { return points_; }
  int observations() const { return observations_; }
  bool has(int point) const { return point >= 0 && point < points_; }
  int add(const Vec<S, 3>& p_map) {
    if (points_ == MaxPoints || !all_finite(p_map)) return none;
    state_[std::size_t(points_)] = p_map;
    first_keyframe_[std::size_t(points_)] = none;
    return points_++;
  }
  int observe(int keyframe, int point, const BearingObservation<S>& seen) {
    if (observations_ == MaxObservations || !has(point) || !seen.is_finite()) return none;
    observation_[std::size_t(observations_)] = {seen, point, std::int16_t(keyframe), true};
    int& first = first_keyframe_[std::size_t(point)];
    if (first == none) first = keyframe;
    return observations_++;
  }
  const Vec<S, 3>& state(int point) const { return state_[std::size_t(point)]; }
  const Vec<S, 3>& trial(int point) const { return trial_[std::size_t(point)]; }
  /// The keyframe of its first observation, or `none`.
  int first_keyframe(int point) const { return first_keyframe_[std::size_t(point)]; }
  /// Observations of a point, for the units of a slice.
  int observations_of(int point) const { return begin_[std::size_t(point) + 1] - begin_[std::size_t(point)]; }
  /// Squared whitened errors at the state.
  typename BearingObservation<S>::Errors errors(int observation, const Keyframes& keyframes) const {
    const Entry& entry = observation_[std::size_t(observation)];
    return entry.seen.errors(keyframes.state(entry.keyframe).view, state(entry.point));
  }

  /// Sorts the observations by point and keyframe. One that is not valid at the start is left out.
  void begin(const Keyframes& keyframes) {
    std::array<int, std::size_t(MaxKeyframes) + 1> begin_keyframe;
    const auto keyframe_of = [this](int o) { return int(observation_[std::size_t(o)].keyframe); };
    counting_sort(
        observations_, MaxKeyframes, begin_keyframe, keyframe_of, [](int o) { return o; }, by_keyframe_);
    const auto point_of = [this](int n) { return observation_[std::size_t(by_keyframe_[std::size_t(n)])].point; };
    const auto observation_of = [this](int n) { return by_keyframe_[std::size_t(n)]; };
    counting_sort(observations_, points_, begin_, point_of, observation_of, order_);
    for (int o = 0; o < observations_; ++o) observation_[std::size_t(o)].is_used = errors(o, keyframes).valid;
    for (int p = 0; p < points_; ++p) trial_[std::size_t(p)] = state(p);
  }

  /// The system of a point, and what its observations add to the poses: (5), (6).
  void linearize(int point, const Keyframes& keyframes, const Losses& losses, System& system, Sums& sums) {
    for (int n = begin_[std::size_t(point)]; n < begin_[std::size_t(point) + 1]; ++n) {
      const Entry& entry = at(n);
      if (!entry.is_used) continue;
      const auto& keyframe = keyframes.state(entry.keyframe);
      const auto products = entry.seen.products(keyframe.view, state(point), losses);
      const Mat<double, 3, 3>& G = G_[std::size_t(n)] = products.G;
      system.H += G;
      system.b += products.g;
      const int block = keyframes.block(entry.keyframe);
      if (block == none) continue;
      const Vec<double, 3> a = cast_to<double>(Vec<S, 3>(state(point) - keyframe.T_map_cam.p()));
      typename System::Strip W;
      for (int c = 0; c < 3; ++c) W[std::size_t(c)] = by_pose(a, column(G, c));
      typename System::Strip& sum = system.strip(block);
      for (std::size_t c = 0; c < 3; ++c) sum[c] += W[c];
      Mat<double, 6, 6>& H = sums.H(block, block);
      add_to_column(H, 0, W[1] * a[2] - W[2] * a[1]);
      add_to_column(H, 1, W[2] * a[0] - W[0] * a[2]);
      add_to_column(H, 2, W[0] * a[1] - W[1] * a[0]);
      for (int c = 0; c < 3; ++c) add_to_column(H, 3 + c, -W[std::size_t(c)]);
      sums.b(block) += by_pose(a, products.g);
    }
  }
  Factor& factor(int point) { return factor_[std::size_t(point)]; }

  /// (7), summed over the observations.
  Vec<double, 3> by_poses(int point, const Keyframes& keyframes) const {
    Vec<double, 3> sum = zeros<double, 3>();
    for (int n = begin_[std::size_t(point)]; n < begin_[std::size_t(point) + 1]; ++n) {
      const Entry& entry = at(n);
      const int block = keyframes.block(entry.keyframe);
      if (!entry.is_used || block == none) continue;
      const Vec<S, 3>& center = keyframes.state(entry.keyframe).T_map_cam.p();
      const Vec<double, 3> a = cast_to<double>(Vec<S, 3>(state(point) - center));
      const Vec<double, 6>& d = keyframes.step(block);
      sum += G_[std::size_t(n)] * Vec<double, 3>(a.cross(segment<3>(d, 0)) - segment<3>(d, 3));
    }
    return sum;
  }
  void make_trial(int point, const Vec<double, 3>& d) { trial_[std::size_t(point)] = state(point) + cast_to<S>(d); }
  void accept() {
    for (int p = 0; p < points_; ++p) state_[std::size_t(p)] = trial_[std::size_t(p)];
  }

  /// Of the observations of a point, at the state or the trial.
  BundleCost cost(int point, bool is_trial, const Keyframes& keyframes, const Losses& losses) const {
    const Vec<S, 3>& p_map = is_trial ? trial(point) : state(point);
    BundleCost out;
    for (int n = begin_[std::size_t(point)]; n < begin_[std::size_t(point) + 1]; ++n) {
      const Entry& entry = at(n);
      if (!entry.is_used) continue;
      const auto& keyframe = is_trial ? keyframes.trial(entry.keyframe) : keyframes.state(entry.keyframe);
      const auto errors = entry.seen.errors(keyframe.view, p_map);
      out.add(double(entry.seen.cost(errors, losses)), errors.valid);
    }
    return out;
  }

 private:
  struct Entry {
    BearingObservation<S> seen;
    int point;
    std::int16_t keyframe;
    bool is_used;
  };

  const Entry& at(int n) const { return observation_[std::size_t(order_[std::size_t(n)])]; }
  /// E^T v
  static Vec<double, 6> by_pose(const Vec<double, 3>& a, const Vec<double, 3>& v) {
    Vec<double, 6> out;
    set_segment(out, 0, v.cross(a));
    set_segment(out, 3, Vec<double, 3>(-v));
    return out;
  }
  static void add_to_column(Mat<double, 6, 6>& H, int c, const Vec<double, 6>& h) {
    for (int r = 0; r < 6; ++r) H.coeffRef(r, c) += h.coeff(r);
  }
  int points_ = 0, observations_ = 0;
  std::array<Vec<S, 3>, std::size_t(MaxPoints)> state_, trial_;
  std::array<int, std::size_t(MaxPoints)> first_keyframe_;
  std::array<int, std::size_t(MaxPoints) + 1> begin_;  ///< of the observations of a point in order_
  std::array<Factor, std::size_t(MaxPoints)> factor_;
  std::array<Entry, std::size_t(MaxObservations)> observation_;
  std::array<int, std::size_t(MaxObservations)> by_keyframe_, order_;
  std::array<Mat<double, 3, 3>, std::size_t(MaxObservations)> G_;  ///< in order
};

}  // namespace plumbline
