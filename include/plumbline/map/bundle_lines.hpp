#pragma once
/// Lines of a bundle adjustment and their segments in keyframes.          docs/math/local_bundle_adjustment.md (14)
///
///   r = (nh . b_a, nh . b_b) / sigma,   n of the line in the camera, residual/world_line.hpp                 (14)
/// A line has the coordinates of geometry/line3.hpp about an origin that does not move: the center of the camera that
/// observed it first.

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/counting_sort.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/line3.hpp"
#include "plumbline/map/bearing_observation.hpp"
#include "plumbline/map/bundle_cost.hpp"
#include "plumbline/map/bundle_keyframes.hpp"
#include "plumbline/residual/world_line.hpp"
#include "plumbline/solver/block_cholesky.hpp"
#include "plumbline/solver/landmark_system.hpp"

namespace plumbline {

/// W += weight J_k^T J, column by column.
template <int R, int N, std::size_t Dim>
void add_products(std::array<Vec<double, N>, Dim>& W, const Mat<double, R, N>& J_k, const Mat<double, R, int(Dim)>& J,
                  double weight) {
  for (std::size_t c = 0; c < Dim; ++c) add_transposed_product(W[c], J_k, column(J, int(c)), weight);
}

template <std::floating_point S, int MaxKeyframes, int MaxLines>
class BundleLines {
 public:
  struct Line {
    Line3<S> state, trial;  ///< about the origin
    Vec<S, 3> origin;
    bool is_anchored;
    Vec<double, 4> step;
  };
  using Keyframes = BundleKeyframes<S, MaxKeyframes>;
  using System = LandmarkSystem<double, 4, 6, MaxKeyframes>;
  using Sums = BlockSums<double, 6, MaxKeyframes>;
  using Losses = BundleLosses<S>;
  static constexpr int none = -1, max_segments = MaxLines * MaxKeyframes;

  void clear() { lines_ = segments_ = 0; }
  int count() const { return lines_; }
  bool has(int line) const { return line >= 0 && line < lines_; }
  int add(const Vec<S, 3>& point_map, const Vec<S, 3>& direction_map) {
    if (lines_ == MaxLines) return none;
    Line& line = line_[std::size_t(lines_)];
    line.is_anchored = false;
    line.origin = point_map + unit_orthogonal(direction_map);  // until it is observed
    line.state = Line3<S>::through(point_map - line.origin, point_map + direction_map - line.origin);
    return line.state.is_finite() && all_finite(line.origin) ? lines_++ : none;
  }
  int add_segment(int keyframe, int line, const Vec<S, 3>& bearing_a, const Vec<S, 3>& bearing_b, S sigma_rad,
                  const Keyframes& keyframes) {
    const S per_sigma = S(1) / sigma_rad;
    if (segments_ == max_segments || !has(line) || !std::isfinite(per_sigma * per_sigma)) return none;
    const WorldLine<LineReprojection<S>> seen{{bearing_a, bearing_b, {per_sigma, per_sigma}}};
    segment_[std::size_t(segments_)] = {seen, line, std::int16_t(keyframe), true};
    anchor(line, keyframes.state(keyframe).T_map_cam.p());
    return segments_++;
  }
  /// The point next to the center of the first camera, and the unit direction, in the map.
  Vec<S, 3> point(int line) const {
    return line_[std::size_t(line)].origin + line_[std::size_t(line)].state.closest_point();
  }
  Vec<S, 3> direction(int line) const { return line_[std::size_t(line)].state.direction(); }
  /// Segments of a line, for the units of a slice.
  int segments_of(int line) const { return begin_[std::size_t(line) + 1] - begin_[std::size_t(line)]; }

  /// Sorts the segments by line. One that is not valid at the start is left out.
  void begin(const Keyframes& keyframes) {
    const auto line_of = [this](int n) { return segment_[std::size_t(n)].line; };
    counting_sort(
        segments_, lines_, begin_, line_of, [](int n) { return n; }, order_);
    for (int n = 0; n < segments_; ++n) {
      Segment& segment = segment_[std::size_t(n)];
      const Line& line = line_[std::size_t(segment.line)];
      segment.is_used =
          segment.seen.linearize(view(line, keyframes.state(segment.keyframe)), line.state.plucker()).valid;
    }
    for (int l = 0; l < lines_; ++l) line_[std::size_t(l)].trial = line_[std::size_t(l)].state;
  }

  /// The system of a line from its segments, and what they add to the poses.
  void linearize(int l, const Keyframes& keyframes, const Losses& losses, Sums& sums) {
    const Line& line = line_[std::size_t(l)];
    System& system = system_[std::size_t(l)];
    system.reset();
    for (int n = begin_[std::size_t(l)]; n < begin_[std::size_t(l) + 1]; ++n) {
      const Segment& segment = at(n);
      const auto& keyframe = keyframes.state(segment.keyframe);
      if (!segment.is_used) continue;
      const auto lin = segment.seen.linearize(view(line, keyframe), line.state.plucker());
      if (!lin.valid) continue;
      const double weight = double(losses.two_rows.weight(squared_norm(lin.r)));
      const auto J_l = cast_to<double>(product(lin.J_r_line, line.state.plucker_jacobian()));
      const Vec<double, 2> r = cast_to<double>(lin.r);
      add_transposed_product(system.H, J_l, J_l, weight);
      add_transposed_product(system.b, J_l, r, weight);
      const int block = keyframes.block(segment.keyframe);
      if (block == none) continue;
      const auto J_k = in_axes_of_map(cast_to<double>(lin.J_r_pose), keyframe.T_map_cam);
      add_transposed_product(sums.H(block, block), J_k, J_k, weight);
      add_transposed_product(sums.b(block), J_k, r, weight);
      add_products(system.strip(block), J_k, J_l, weight);
    }
  }
  /// From the poses and all that its points left.
  bool eliminate(int l, double mu, Sums& sums) {
    return system_[std::size_t(l)].eliminate(mu, factor_[std::size_t(l)], sums);
  }

  /// The step of a line; returns its predicted decrease.
  double solve(int l, const Keyframes& keyframes) {
    const System& system = system_[std::size_t(l)];
    Vec<double, 4> Y_d = zeros<double, 4>();
    for (int n = 0; n < system.blocks(); ++n) {
      for (int m = 0; m < 4; ++m) Y_d[m] += dot(system.at(n)[std::size_t(m)], keyframes.step(system.block(n)));
    }
    full_step_ = factor_[std::size_t(l)].step_divided(Y_d);
    return factor_[std::size_t(l)].predicted_decrease(full_step_);
  }
  /// The trial with a share of the step of the last `solve`.
  void make_trial(int l, double share) {
    Line& line = line_[std::size_t(l)];
    line.step = share * full_step_;
    line.trial = line.state.plus(cast_to<S>(line.step));
  }
  void accept() {
    for (int l = 0; l < lines_; ++l) line_[std::size_t(l)].state = line_[std::size_t(l)].trial;
  }

  /// Of the segments of a line, at the state or the trial.
  BundleCost cost(int l, bool is_trial, const Keyframes& keyframes, const Losses& losses) const {
    const Line& line = line_[std::size_t(l)];
    const Plucker<S> plucker = (is_trial ? line.trial : line.state).plucker();
    BundleCost out;
    for (int n = begin_[std::size_t(l)]; n < begin_[std::size_t(l) + 1]; ++n) {
      const Segment& segment = at(n);
      if (!segment.is_used) continue;
      const auto& keyframe = is_trial ? keyframes.trial(segment.keyframe) : keyframes.state(segment.keyframe);
      const LineReprojection<S>& seen = segment.seen.measurement;
      const Plucker<S> in_cam = line_in_camera(view(line, keyframe), plucker);
      const bool is_valid = line_visible<S>(in_cam, seen.bearing_start + seen.bearing_end);
      const S squared = is_valid ? squared_norm(seen.residual(in_cam)) : squared_norm(seen.px_per_rad);
      out.add(double(losses.two_rows.rho(squared)), is_valid);
    }
    return out;
  }

  const Line& line(int l) const { return line_[std::size_t(l)]; }
  System& system(int l) { return system_[std::size_t(l)]; }
  /// The origin becomes the center of the camera that observes the line, or a point on it, first.
  void anchor(int l, const Vec<S, 3>& center) {
    Line& line = line_[std::size_t(l)];
    if (line.is_anchored) return;
    const Vec<S, 3> p = line.origin + line.state.closest_point() - center;
    line.state = Line3<S>::through(p, p + line.state.direction());
    line.origin = center;
    line.is_anchored = true;
  }

 private:
  struct Segment {
    WorldLine<LineReprojection<S>> seen;
    int line;
    std::int16_t keyframe;
    bool is_used;
  };
  const Segment& at(int n) const { return segment_[std::size_t(order_[std::size_t(n)])]; }
  /// Of a keyframe, about the origin of the line.
  static BodyView<S> view(const Line& line, const typename Keyframes::Keyframe& keyframe) {
    BodyView<S> out = keyframe.view;
    out.p_world_body -= line.origin;
    return out;
  }
  static constexpr std::size_t some(int n) { return std::size_t(MaxLines > 0 ? n : 1); }

  int lines_ = 0, segments_ = 0;
  Vec<double, 4> full_step_;
  std::array<Line, some(MaxLines)> line_;
  std::array<System, some(MaxLines)> system_;
  std::array<typename System::Factor, some(MaxLines)> factor_;
  std::array<Segment, some(max_segments)> segment_;
  std::array<int, std::size_t(MaxLines) + 1> begin_;
  std::array<int, some(max_segments)> order_;
};

}  // namespace plumbline
