#pragma once
/// OpenCV's LSD in the place of LineSegmentDetector: Lines<60, opencv::LsdDetector<>>.      docs/math/line.md
///
/// It works on the image scaled by s and multiplies positions by 1/s, which maps centers of pixels to centers only for
/// s = 1: the middle of pixel x of the small image is at (x + 1/2)/s - 1/2. Hence
///   uv = uv_opencv + (1/s - 1)/2 (1, 1)                                                                   (33)
/// LSD has the brighter side on the other hand and no gradient; both are read off the profile across. Parts of one edge
/// are merged. Versions 3.4.6 to 4.5.3 of OpenCV have no LSD: cv::Exception.

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/tracking/line_detector.hpp"
#include "plumbline/tracking/line_profile.hpp"

namespace plumbline::opencv {

/// Those of cv::createLineSegmentDetector. An estimator makes its own detector: other values are a type derived from
/// this one, whose constructor sets them.
struct LsdParameters {
  int refine = cv::LSD_REFINE_STD;
  double scale = 0.8;
  double sigma_scale = 0.6;           ///< the scaled image is smoothed by sigma_scale/scale [px]
  double gradient_error = 2.0;        ///< of quantization [intensity]
  double angle_tolerance_deg = 22.5;  ///< of gradients in one segment
  double log_eps = 0;                 ///< for LSD_REFINE_ADV alone
  double min_density = 0.7;           ///< of aligned pixels in the rectangle around a segment
  int bins = 1024;                    ///< of the gradients' order
};

template <std::derived_from<LsdParameters> Parameters = LsdParameters, std::size_t MaxCandidates = 300>
class LsdDetector {
 public:
  explicit LsdDetector(const LsdParameters& p = Parameters())
      : shift_(static_cast<float>(0.5 / p.scale - 0.5)),
        lsd_(cv::createLineSegmentDetector(p.refine, p.scale, p.sigma_scale, p.gradient_error, p.angle_tolerance_deg,
                                           p.log_eps, p.min_density, p.bins)) {}

  /// Replaces `out` by the segments of the image, longest first; the shortest are left out when it is too small. Of
  /// `options` only the length and the rules of merging count.
  template <std::size_t N>
  void detect(const ImageView<const std::uint8_t>& image, const LineDetectorOptions& options,
              FixedVector<LineSegment, N>& out) {
    out.clear();
    candidates_.clear();
    if (image.empty()) return;
    lsd_->detect(mat(image), found_);
    std::sort(found_.begin(), found_.end(),
              [](const cv::Vec4f& a, const cv::Vec4f& b) { return squared_length(a) > squared_length(b); });
    for (const cv::Vec4f& s : found_) {
      LineSegment segment{{s[0] + shift_, s[1] + shift_}, {s[2] + shift_, s[3] + shift_}};
      if (set_polarity(image, segment) && !candidates_.push_back(segment)) break;
    }
    merge_collinear(candidates_, options.merge);
    for (const LineSegment& segment : candidates_) {
      if (segment.length() < options.min_length_px || !out.push_back(segment)) break;
    }
  }
  /// The same as a LineDetector.
  template <std::size_t MaxPixels, std::size_t N>
  void detect(const ImageView<const std::uint8_t>& image, EdgeMap<MaxPixels>&, const LineDetectorOptions& options,
              FixedVector<LineSegment, N>& out) {
    detect(image, options, out);
  }

 private:
  static float squared_length(const cv::Vec4f& s) {
    return (s[2] - s[0]) * (s[2] - s[0]) + (s[3] - s[1]) * (s[3] - s[1]);
  }

  /// Gradient across by the kernel of the edge map, (18). False without one, as at the image's edge.
  static bool set_polarity(const ImageView<const std::uint8_t>& image, LineSegment& segment) {
    const LineProfile profile = profile_of(image, segment);
    const auto rise = [&](int d) {
      return profile.mean[LineProfile::radius + d] - profile.mean[LineProfile::radius - d];
    };
    segment.gradient = (2 * rise(1) + rise(2)) / 8;
    if (segment.gradient < 0) {
      std::swap(segment.start, segment.end);
      segment.gradient = -segment.gradient;
    }
    return segment.gradient > 0;
  }

  float shift_;  ///< (33) [px]
  cv::Ptr<cv::LineSegmentDetector> lsd_;
  std::vector<cv::Vec4f> found_;
  FixedVector<LineSegment, MaxCandidates> candidates_;
};

static_assert(LineDetector<LsdDetector<>>);

}  // namespace plumbline::opencv
