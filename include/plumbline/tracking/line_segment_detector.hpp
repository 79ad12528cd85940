#pragma once
/// Straight edges of an image: ridges of the gradient are walked, chains of pixels cut into straight runs, runs fitted
/// with sub-pixel positions.                                                                docs/math/line.md
///
///   run     a window of pixels whose RMS distance to its line is at most `max_rms_px`, extended while pixels stay
///           within `max_distance_px` of the line through all pixels so far
///   fit     total least squares of the ridge's sub-pixel positions, twice, without those beyond `max_distance_px` (19)
///   accept  length, RMS, and the share of pixels whose gradient agrees with the normal within 22.5 degrees
/// The work is linear in the pixels. Deterministic, no heap.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/tracking/edge_map.hpp"
#include "plumbline/tracking/follow_edge.hpp"
#include "plumbline/tracking/line_fit.hpp"
#include "plumbline/tracking/line_segment.hpp"

namespace plumbline {

struct LineDetectorOptions {
  float min_length_px = 25.0f;
  float min_gradient = 1.6f;     ///< gradient of the weakest edge [intensity/px]: above the camera's noise
  float max_rms_px = 0.5f;       ///< of the pixels of a run about its line
  float max_distance_px = 1.2f;  ///< of a pixel that still belongs to a run
  int max_misses = 4;            ///< pixels in a row that a run may lose
  float min_aligned = 0.75f;     ///< share of pixels whose gradient agrees with the line
  int anchor_spacing_px = 6;     ///< edges are looked for in every so many rows and columns
  MergeOptions merge;
};

template <std::size_t MaxCandidates = 300>
class LineSegmentDetector {
 public:
  /// Replaces `out` by the segments of the image, longest first; the shortest are left out when it is too small. The
  /// map was computed with `min_gradient`; its pixels are taken once, by the first detection.
  template <std::size_t MaxPixels, std::size_t N>
  void detect(EdgeMap<MaxPixels>& edges, const LineDetectorOptions& options, FixedVector<LineSegment, N>& out) {
    out.clear();
    candidates_.clear();
    edges.for_each_chain(options.anchor_spacing_px, chain_,
                         [&](const EdgeChain& chain) { cut(edges, chain, options); });
    merge_collinear(candidates_, options.merge);
    for (const LineSegment& segment : candidates_) {
      if (segment.length() < options.min_length_px || !out.push_back(segment)) break;
    }
  }
  /// The same as a LineDetector: the map has all that is used of the image.
  template <std::size_t MaxPixels, std::size_t N>
  void detect(const ImageView<const std::uint8_t>&, EdgeMap<MaxPixels>& edges, const LineDetectorOptions& options,
              FixedVector<LineSegment, N>& out) {
    detect(edges, options, out);
  }

 private:
  using Moments = LineMoments<std::int64_t>;

  /// The straight runs of a chain.
  template <class Edges>
  void cut(const Edges& edges, const EdgeChain& chain, const LineDetectorOptions& options) {
    // A run's pixels are as many as its extent along the nearer axis.
    const std::size_t window = static_cast<std::size_t>(std::max(8.0f, 0.5f * options.min_length_px));
    const float max_variance = options.max_rms_px * options.max_rms_px;
    const auto add = [&](Moments& moments, std::size_t i, int sign) { moments.add(chain[i].x, chain[i].y, sign); };
    std::size_t first = 0;
    while (first + window <= chain.size()) {
      Moments moments;
      for (std::size_t i = first; i < first + window; ++i) add(moments, i, 1);
      while (!moments.is_straight(max_variance)) {
        if (first + window == chain.size()) return;
        add(moments, first, -1);
        add(moments, first + window, 1);
        ++first;
      }
      FittedLine line = moments.line();
      std::size_t end = first + window;
      int misses = 0, added = 0;
      for (std::size_t i = end; i < chain.size() && misses <= options.max_misses; ++i) {
        if (!(std::abs(line.distance(Vec<float, 2>(chain[i].x, chain[i].y))) <= options.max_distance_px)) {
          ++misses;
          continue;
        }
        misses = 0;
        end = i + 1;
        add(moments, i, 1);
        if (++added % refit_interval == 0) line = moments.line();
      }
      fit(edges, chain, first, end, options);
      first = end;
    }
  }

  /// Keeps the line through chain pixels [first, end) when it is acceptable.
  template <class Edges>
  void fit(const Edges& edges, const EdgeChain& chain, std::size_t first, std::size_t end,
           const LineDetectorOptions& options) {
    const float shortest = 0.8f * options.min_length_px;
    const float dx = float(chain[end - 1].x - chain[first].x), dy = float(chain[end - 1].y - chain[first].y);
    constexpr float peaks = 3;  // what sub-pixel positions may add at both ends [px]
    if (!(std::sqrt(dx * dx + dy * dy) + peaks > shortest)) return;
    const EdgePixel& middle = chain[(first + end) / 2];
    const Vec<float, 2> origin(middle.x, middle.y);  // small numbers: float sums stay exact enough
    LineMoments<float> moments;
    points_.clear();
    for (std::size_t i = first; i < end; ++i) {
      points_.push_back(edges.peak(chain[i]) - origin);
      moments.add(points_.back().x(), points_.back().y());
    }
    FittedLine line = moments.line();
    const auto belongs = [&](const Vec<float, 2>& point) {
      return std::abs(line.distance(point)) < options.max_distance_px;
    };
    const bool all_belong = std::all_of(points_.begin(), points_.end(), belongs);
    for (int iteration = 0; iteration < 2 && !all_belong; ++iteration) {
      moments = {};
      for (const Vec<float, 2>& point : points_) {
        if (belongs(point)) moments.add(point.x(), point.y());
      }
      if (!(moments.n >= 8.0f)) return;
      line = moments.line();
    }
    if (!(line.variance < options.max_rms_px * options.max_rms_px)) return;
    // A chain runs with the brighter side on its fixed hand, and so does the segment.
    if (line.along(points_.back()) < line.along(points_[0])) line.direction = -line.direction;
    const Vec<float, 2> normal(-line.direction.y(), line.direction.x());
    float from = line.along(points_.back()), to = line.along(points_[0]), slope = 0;
    int aligned = 0;
    for (std::size_t k = 0; k < points_.size(); ++k) {
      if (!belongs(points_[k])) continue;
      const float across = edges.aligned_slope(origin + points_[k], normal);
      aligned += across > 0;
      slope += across;
      from = std::min(from, line.along(points_[k]));
      to = std::max(to, line.along(points_[k]));
    }
    if (!(static_cast<float>(aligned) > options.min_aligned * static_cast<float>(points_.size()))) return;
    if (!(to - from > shortest)) return;
    LineSegment segment;
    segment.start = line.at(from);
    segment.end = line.at(to);
    segment.gradient = slope / static_cast<float>(aligned);
    // What the chain lost in rounded corners, in gaps and to other chains; farther the line's angle is too uncertain.
    const FollowOptions follow{0.5f * options.min_gradient, options.max_distance_px, options.max_misses,
                               static_cast<int>(0.5f * moments.n)};
    follow_edge(edges, origin, follow, -1, line, moments, segment.start);
    follow_edge(edges, origin, follow, 1, line, moments, segment.end);
    segment.start = origin + line.at(line.along(segment.start));
    segment.end = origin + line.at(line.along(segment.end));
    keep(segment);
  }

  void keep(const LineSegment& segment) {
    const auto longer = [](const LineSegment& a, const LineSegment& b) {  // for a heap, the shortest on top
      return squared_norm(a.end - a.start) > squared_norm(b.end - b.start);
    };
    if (candidates_.full()) {
      if (!longer(segment, candidates_[0])) return;
      std::pop_heap(candidates_.begin(), candidates_.end(), longer);
      candidates_.pop_back();
    }
    candidates_.push_back(segment);
    std::push_heap(candidates_.begin(), candidates_.end(), longer);
  }

  static constexpr int refit_interval = 8;

  EdgeChain chain_;
  FixedVector<Vec<float, 2>, EdgeChain::capacity()> points_;
  FixedVector<LineSegment, MaxCandidates> candidates_;
};

}  // namespace plumbline
