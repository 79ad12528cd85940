#pragma once
/// A straight edge followed from frame to frame without descriptors.                        docs/math/line.md
///
/// At samples along the predicted segment the edges of the same polarity and a similar gradient are looked for on the
/// normal. Their consensus is a line
///   offset(t) = a + b t   along the prediction,  score = sum of gradient similarities (1 - 0.3 |a| / search)   (20)
/// over pairs of them. The winner is fitted to the sub-pixel peaks and cut to what is supported without a large gap:
/// where an occlusion splits an edge the longer part continues. Then it is extended at both ends, and its profile
/// across must resemble the one before (the check that a search backwards would be). Two tracks that overlap on one
/// edge are one: `mark_duplicates`. The work of one segment is bounded.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/tracking/edge_queries.hpp"
#include "plumbline/tracking/follow_edge.hpp"
#include "plumbline/tracking/line_fit.hpp"
#include "plumbline/tracking/line_profile.hpp"
#include "plumbline/tracking/line_segment.hpp"

namespace plumbline {

struct LineTrackingOptions {
  float search_px = 16.0f;       ///< along the normal to both sides; at most 60
  float max_angle_rad = 0.35f;   ///< between prediction and result
  float max_slope_ratio = 2.5f;  ///< of an edge's gradient to the segment's, either way
  float max_distance_px = 1.2f;  ///< of a peak to the line it belongs to
  float max_rms_px = 0.6f;       ///< of all peaks
  float min_length_px = 20.0f;   ///< of what is found
  float min_support = 0.6f;      ///< share of the samples inside the image and the found extent
  float max_gap_px = 16.0f;      ///< without support, inside of the found extent
  float max_growth_px = 20.0f;   ///< a frame, at each end
  float min_similarity = 0.8f;   ///< of the profiles across, before and now
};

struct TrackedLine {
  bool valid = false;
  LineSegment segment;
  LineProfile profile;
  float rms_px = 0;
  float support = 0;  ///< share of the samples
};

class LineTracker {
 public:
  /// Finds the segment whose profile in its last image was `profile` near `guess`, which has the segment's gradient.
  template <class Edges>
  TrackedLine track(const Edges& edges, const ImageView<const std::uint8_t>& image, const LineProfile& profile,
                    const LineSegment& guess, const LineTrackingOptions& options) {
    TrackedLine out;
    length_ = guess.length();
    if (!(length_ > 1.0f && length_ < max_length_px && guess.gradient > 0)) return out;  // false for NaN too
    sample(edges, guess, options);
    const Offset offset = find_offset(options);
    if (!(offset.score > 0)) return out;
    if (!fit(edges, guess, offset, options, out)) return out;
    out.profile = profile_of(image, out.segment);
    const float angle_cosine = dot(out.segment.direction(), guess.direction());
    out.valid = out.segment.length() >= options.min_length_px &&
                angle_cosine > elementary::cos(options.max_angle_rad) &&
                out.profile.similarity(profile) > options.min_similarity;
    return out;
  }

 private:
  static constexpr int max_samples = 24, max_per_sample = 4, max_search_px = 60;
  static constexpr float min_spacing_px = 3, max_length_px = 1e5f;

  /// An edge on the normal through a sample.
  struct Candidate {
    int sample;
    float along, offset;  ///< in the prediction's axes, from its center [px]
    float weight;         ///< similarity of its gradient, at most 1
    Vec<float, 2> peak;   ///< [px]
  };
  /// (20)
  struct Offset {
    float a = 0, b = 0, score = 0;
    bool close_to(const Candidate& c, float distance_px) const {
      return std::abs(c.offset - a - b * c.along) < distance_px;
    }
  };

  template <class Edges>
  void sample(const Edges& edges, const LineSegment& guess, const LineTrackingOptions& options) {
    candidates_.clear();
    const Vec<float, 2> center = guess.center(), direction = guess.direction(), normal = guess.normal();
    samples_ = std::clamp(static_cast<int>(length_ / min_spacing_px), 6, max_samples);
    const float lowest = guess.gradient / options.max_slope_ratio, highest = guess.gradient * options.max_slope_ratio;
    const int range = std::clamp(static_cast<int>(options.search_px), 1, max_search_px);
    for (int k = 0; k < samples_; ++k) {
      const float along = length_ * ((static_cast<float>(k) + 0.5f) / static_cast<float>(samples_) - 0.5f);
      const Vec<float, 2> at = center + along * direction;
      inside_[static_cast<std::size_t>(k)] = edges.contains(at);
      edges.aligned_slopes(at, normal, range + 1, slopes_.data());
      int found = 0;
      for (int i = 0; i <= 2 * range && found < max_per_sample; ++i) {  // 0, 1, -1, 2, -2 ...
        const int j = i % 2 == 0 ? -i / 2 : (i + 1) / 2;
        const float* const slope = slopes_.data() + range + 1 + j;
        const float here = slope[0];
        if (!(lowest < here && here < highest && slope[-1] < here && slope[1] <= here)) continue;
        const float weight = std::min(here / guess.gradient, guess.gradient / here);
        const Vec<float, 2> peak = edges.peak(nearest_pixel(at + static_cast<float>(j) * normal));
        candidates_.push_back({k, dot(direction, peak - center), dot(normal, peak - center), weight, peak});
        ++found;
      }
    }
  }

  /// The best line through two candidates, by (20).
  Offset find_offset(const LineTrackingOptions& options) const {
    constexpr std::size_t max_candidates = 12;  // at most 66 pairs
    Offset best;
    if (candidates_.empty()) return best;
    const std::size_t n = std::min(candidates_.size(), max_candidates);
    const auto sample = [&](std::size_t i) -> const Candidate& { return candidates_[i * candidates_.size() / n]; };
    const float steepest = elementary::tan(options.max_angle_rad);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = i + 1; j < n; ++j) {
        const float along = sample(j).along - sample(i).along;
        if (!(along > 0.3f * length_)) continue;
        Offset line;
        line.b = (sample(j).offset - sample(i).offset) / along;
        line.a = sample(i).offset - line.b * sample(i).along;
        if (!(std::abs(line.b) < steepest && std::abs(line.a) <= options.search_px)) continue;
        int last = -1;
        for (const Candidate& c : candidates_) {
          if (c.sample == last || !line.close_to(c, options.max_distance_px)) continue;
          line.score += c.weight;
          last = c.sample;
        }
        line.score *= 1 - 0.3f * std::abs(line.a) / options.search_px;
        if (line.score > best.score) best = line;
      }
    }
    return best;
  }

  /// The line through the peaks that support the offset, cut to its supported part and followed on from there.
  template <class Edges>
  bool fit(const Edges& edges, const LineSegment& guess, const Offset& offset, const LineTrackingOptions& options,
           TrackedLine& out) {
    const Vec<float, 2> origin = guess.center();
    FittedLine line;
    line.direction = normalized(guess.direction() + offset.b * guess.normal());
    line.mean = offset.a * guess.normal();
    LineMoments<float> moments;
    Extent extent;
    for (int iteration = 0; iteration < 2; ++iteration) {
      extent = supported(origin, line, options);
      if (extent.samples < 4) return false;
      moments = {};
      for (int k = extent.first; k <= extent.last; ++k) {
        const Candidate* c = support_[static_cast<std::size_t>(k)];
        if (c != nullptr) moments.add(c->peak.x() - origin.x(), c->peak.y() - origin.y());
      }
      const Vec<float, 2> direction = line.direction;
      line = moments.line();
      if (dot(line.direction, direction) < 0) line.direction = -line.direction;
    }
    const Vec<float, 2> normal(-line.direction.y(), line.direction.x());
    int inside = 0;
    float slope_sum = 0;
    for (int k = extent.first; k <= extent.last; ++k) {
      const Candidate* c = support_[static_cast<std::size_t>(k)];
      inside += inside_[static_cast<std::size_t>(k)];
      if (c != nullptr) slope_sum += edges.aligned_slope(c->peak, normal);
    }
    out.support = static_cast<float>(extent.samples) / static_cast<float>(std::max(inside, 1));
    out.rms_px = std::sqrt(line.variance);
    if (!(out.support >= options.min_support && out.rms_px <= options.max_rms_px)) return false;
    out.segment.gradient = slope_sum / static_cast<float>(extent.samples);
    const auto peak = [&](int k) { return Vec<float, 2>(support_[static_cast<std::size_t>(k)]->peak - origin); };
    out.segment.start = peak(extent.first);
    out.segment.end = peak(extent.last);
    const FollowOptions follow{out.segment.gradient / options.max_slope_ratio, options.max_distance_px, 4,
                               static_cast<int>(options.max_growth_px)};
    follow_edge(edges, origin, follow, -1, line, moments, out.segment.start);
    follow_edge(edges, origin, follow, 1, line, moments, out.segment.end);
    out.segment.start = origin + line.at(line.along(out.segment.start));
    out.segment.end = origin + line.at(line.along(out.segment.end));
    return true;
  }

  /// A run of samples with support, ends included.
  struct Extent {
    int first = 0, last = -1, samples = 0;
  };

  /// Fills `support_` with the nearest candidate of each sample, and finds the longest run of them without a large gap.
  Extent supported(const Vec<float, 2>& origin, const FittedLine& line, const LineTrackingOptions& options) {
    support_.fill(nullptr);
    for (const Candidate& c : candidates_) {
      const Candidate*& best = support_[static_cast<std::size_t>(c.sample)];
      const float distance = std::abs(line.distance(c.peak - origin));
      if (!(distance < options.max_distance_px)) continue;
      if (best == nullptr || distance < std::abs(line.distance(best->peak - origin))) best = &c;
    }
    const float max_gap_px = std::max(options.max_gap_px, 2.5f * length_ / static_cast<float>(samples_));
    Extent longest, run;
    float last_along = 0;
    for (int k = 0; k < samples_; ++k) {
      const Candidate* c = support_[static_cast<std::size_t>(k)];
      if (c == nullptr) continue;
      if (run.samples == 0 || c->along - last_along > max_gap_px) run = {k, k, 0};
      run.last = k;
      ++run.samples;
      last_along = c->along;
      if (run.samples > longest.samples) longest = run;
    }
    return longest;
  }

  std::array<float, 2 * max_search_px + 3> slopes_;  ///< on the normal of the current sample
  FixedVector<Candidate, max_samples * max_per_sample> candidates_;
  std::array<const Candidate*, max_samples> support_;
  std::array<bool, max_samples> inside_;
  float length_ = 0;  ///< of the prediction [px]
  int samples_ = 0;
};

/// Sets `duplicate[j]` where segment j overlaps on one edge with an earlier one that is not a duplicate itself.
template <std::size_t N>
void mark_duplicates(const FixedVector<LineSegment, N>& segments, std::array<bool, N>& duplicate) {
  MergeOptions overlapping;
  overlapping.max_gap_px = 0;
  for (std::size_t j = 0; j < segments.size(); ++j) {
    duplicate[j] = false;
    for (std::size_t i = 0; i < j && !duplicate[j]; ++i) {
      duplicate[j] = !duplicate[i] && are_one(segments[i], segments[j], overlapping);
    }
  }
}

}  // namespace plumbline
