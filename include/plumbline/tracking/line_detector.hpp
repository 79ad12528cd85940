#pragma once
/// What finds new segments for a map of lines: LineSegmentDetector, opencv::LsdDetector, or one of yours.

#include <concepts>
#include <cstdint>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/tracking/edge_map.hpp"
#include "plumbline/tracking/line_segment.hpp"
#include "plumbline/tracking/line_segment_detector.hpp"

namespace plumbline {

/// detect() replaces `out` by segments of the image, longest first, none shorter than `options.min_length_px`, each
/// with its polarity and gradient. `edges` is the map of the same image, computed with `options.min_gradient`, its
/// pixels not taken yet; a detector may take them. Both have any capacity.
template <class D>
concept LineDetector = std::default_initializable<D> &&
    requires(D& detector, const ImageView<const std::uint8_t>& image, EdgeMap<1>& edges,
             const LineDetectorOptions& options, FixedVector<LineSegment, 1>& out) {
  detector.detect(image, edges, options, out);
};

static_assert(LineDetector<LineSegmentDetector<>>);
static_assert(!LineDetector<LineDetectorOptions>);

}  // namespace plumbline
