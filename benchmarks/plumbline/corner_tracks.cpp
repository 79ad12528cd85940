#include "corner_tracks.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include <opencv2/core.hpp>

#include "images.hpp"
#include "mask.hpp"
#include "plumbline/camera/any_camera.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/image/image_mask.hpp"
#include "plumbline/image/pyramid.hpp"
#include "plumbline/io/make_camera.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/tracking/corner_detector.hpp"
#include "plumbline/tracking/optical_flow.hpp"

namespace pl = plumbline;
namespace io = plumbline::io;

namespace {

constexpr std::size_t most_corners = 200;
constexpr std::size_t largest_image = 4096 * 2304;  // [px]
using TrackingPyramid = pl::Pyramid<5, largest_image>;

/// Follows corners, and looks for new ones where there are none.
class CornerTracker {
 public:
  explicit CornerTracker(const io::Calibration& calibration)
      : camera_(io::make_camera<double>(calibration.camera)), depth_scale_(calibration.depth_scale) {
    const double pixels = double(calibration.camera.width) * calibration.camera.height;
    options_.cell_px = std::max(16, int(std::sqrt(pixels / most_corners)));
    mask_->set(pl::opencv::view<std::uint8_t>(read_mask(calibration)));
  }

  /// `is_first`: nothing is followed.
  std::vector<TrackedCorner> add(const Images& images, bool is_first) {
    std::swap(previous_, current_);
    const auto view = pl::opencv::view<std::uint8_t>(images.gray);
    std::vector<TrackedCorner> out;
    if (!current_->build(view)) return out;
    if (!is_first) {
      for (const TrackedCorner& corner : corners_) {
        const pl::Vec<float, 2> uv = corner.uv.cast<float>();
        const pl::FlowResult flow = pl::track_point_checked<12>(*previous_, *current_, uv, uv, {});
        if (flow.valid) add(corner.id, flow.uv, images.depth, out);
      }
    }
    find_new(view, images.depth, out);
    corners_ = out;
    return out;
  }

 private:
  void add(std::uint32_t id, const pl::Vec<float, 2>& uv, const cv::Mat& depth, std::vector<TrackedCorner>& out) const {
    const pl::Unprojection<double> ray = camera_.unproject(uv.cast<double>());
    const auto view = current_->level(0);
    const float border = float(options_.border_px);  // also for the patches of the pyramid's top level
    if (!ray.valid || uv.x() < border || uv.y() < border || uv.x() > float(view.width) - border ||
        uv.y() > float(view.height) - border || mask_->view().excludes(uv))
      return;
    double depth_m = 0;
    if (!depth.empty() && depth_scale_ > 0) {
      const int x = std::clamp(int(std::lround(uv.x())), 0, depth.cols - 1);
      const int y = std::clamp(int(std::lround(uv.y())), 0, depth.rows - 1);
      depth_m = depth.at<std::uint16_t>(y, x) / depth_scale_;
    }
    out.push_back({id, uv.cast<double>(), ray.bearing, depth_m});
  }

  void find_new(const pl::ImageView<const std::uint8_t>& view, const cv::Mat& depth, std::vector<TrackedCorner>& out) {
    std::vector<pl::Vec<float, 2>> existing;
    existing.reserve(out.size());
    for (const TrackedCorner& corner : out) existing.push_back(corner.uv.cast<float>());
    pl::FixedVector<pl::Corner, most_corners> found;
    pl::detect_corners(view, existing.data(), existing.size(), options_, found, mask_->view());
    for (const pl::Corner& corner : found) add(next_id_++, corner.uv, depth, out);
  }

  pl::AnyCamera<double> camera_;
  double depth_scale_;
  pl::CornerOptions options_;
  std::unique_ptr<pl::ImageMask<largest_image>> mask_ = std::make_unique<pl::ImageMask<largest_image>>();
  std::unique_ptr<TrackingPyramid> previous_ = std::make_unique<TrackingPyramid>(),
                                   current_ = std::make_unique<TrackingPyramid>();
  std::vector<TrackedCorner> corners_;
  std::uint32_t next_id_ = 0;
};

/// Begins of blocks of `length` frames.
std::vector<std::size_t> blocks(std::size_t frames, std::size_t most, std::size_t length) {
  if (frames <= most) return {0};
  std::vector<std::size_t> out;
  const std::size_t n = most / length;
  for (std::size_t i = 0; i < n; ++i) out.push_back(i * (frames - length) / std::max<std::size_t>(n - 1, 1));
  return out;
}

}  // namespace

bool can_track(const io::CameraCalibration& camera) {
  constexpr int smallest = 256;  // 16 px on the top level
  return camera.width >= smallest && camera.height >= smallest &&
         static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height) <= largest_image;
}

std::vector<TrackedFrame> track_corners(const io::Recording& recording, std::size_t most) {
  constexpr std::size_t block = 100;
  constexpr double depth_interval_s = 0.22;  // 0.25 at 20 Hz
  const std::vector<io::FrameSample>& frames = recording.frames();
  const std::size_t length = frames.size() <= most ? frames.size() : block;
  CornerTracker tracker(recording.calibration());
  std::vector<TrackedFrame> out;
  std::optional<pl::TimeNs> last_depth_ns;
  for (const std::size_t begin : blocks(frames.size(), most, block)) {
    bool follows = false;
    for (std::size_t i = begin; i < begin + length; ++i) {
      Images images;
      const bool with_depth =
          recording.has_depth() && frames[i].depth &&
          (!last_depth_ns || pl::seconds_between(*last_depth_ns, frames[i].t_ns) > depth_interval_s);
      try {
        images = read_images(frames[i], with_depth);
        pl::opencv::require_resolution(images.gray, recording.calibration().camera.width,
                                       recording.calibration().camera.height, frames[i].image);
        if (!images.depth.empty() && images.depth.size() != images.gray.size()) images.depth.release();
      } catch (const std::runtime_error&) {
        follows = false;
        continue;
      }
      if (with_depth) last_depth_ns = frames[i].t_ns;
      cv::Scalar mean, deviation;
      cv::meanStdDev(images.gray, mean, deviation);
      out.push_back({frames[i].t_ns, follows, tracker.add(images, !follows), mean[0], deviation[0]});
      follows = true;
    }
  }
  return out;
}

std::vector<CornerPair> pairs_of(const TrackedFrame& first, const TrackedFrame& second) {
  std::vector<CornerPair> out;  // both are in order of their ids
  auto a = first.corners.begin();
  for (const TrackedCorner& b : second.corners) {
    while (a != first.corners.end() && a->id < b.id) ++a;
    if (a != first.corners.end() && a->id == b.id) out.push_back({&*a, &b});
  }
  return out;
}
