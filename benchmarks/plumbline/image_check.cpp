// Whether there is anything to see in the images, and whether depth is in meters.
#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/core.hpp>

#include "format.hpp"
#include "plumbline/sensor/depth_sensor.hpp"
#include "recording_check.hpp"

namespace pl = plumbline;
namespace io = plumbline::io;

namespace {

constexpr std::size_t looked_at = 6;  // images, spread over the recording

std::vector<io::FrameSample> some_of(const std::vector<io::FrameSample>& frames) {
  std::vector<io::FrameSample> out;
  const std::size_t n = std::min(looked_at, frames.size());
  for (std::size_t i = 0; i < n; ++i) out.push_back(frames[i * (frames.size() - 1) / std::max<std::size_t>(n - 1, 1)]);
  return out;
}

/// What an image looks like; the run names those that cannot be read.
struct Look {
  int read = 0, blank = 0;
  double mean = 0, contrast = 0;  // of the richest
};

void look_at(const cv::Mat& gray, Look& look) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(gray, mean, deviation);
  constexpr double least_contrast = 3;  // the noise of a camera with its cap on
  ++look.read;
  look.blank += deviation[0] < least_contrast;
  if (look.read > 1 && deviation[0] <= look.contrast) return;
  look.mean = mean[0];
  look.contrast = deviation[0];
}

void check_look(const std::string& file, const Look& look, std::vector<Finding>& findings) {
  if (look.read == 0 || 2 * look.blank < look.read) return;
  const std::string kind = look.mean < 20 ? "black" : look.mean > 235 ? "white" : "blank";
  if (look.blank == look.read) {
    findings.push_back(
        {true, file + format("all %d images looked at are %s (mean %.0f, contrast %.1f of 255), expected a contrast "
                             "of 10 or more: is the lens covered?",
                             look.read, kind.c_str(), look.mean, look.contrast)});
  } else {
    findings.push_back({false, file + format("%d of %d images looked at are blank (contrast below 3 of 255), expected "
                                             "none",
                                             look.blank, look.read)});
  }
}

/// What depth images hold.
struct Depths {
  int read = 0;
  double measured = 0;           // part of the pixels, summed
  std::vector<double> raw = {};  // the median of each image
  std::string unreadable = {};   // why the first one that cannot be read cannot
};

void look_at_depth(const cv::Mat& depth, Depths& depths) {
  std::vector<std::uint16_t> values;
  for (int y = 0; y < depth.rows; y += 2)
    for (int x = 0; x < depth.cols; x += 2)
      if (const auto value = depth.at<std::uint16_t>(y, x); value != 0) values.push_back(value);
  ++depths.read;
  depths.measured += 4.0 * static_cast<double>(values.size()) / static_cast<double>(depth.total());
  if (values.empty()) return;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  depths.raw.push_back(*middle);
}

void check_depths(const io::Recording& recording, const Depths& depths, std::vector<Finding>& findings) {
  const std::string file = recording.files().depth_index->string() + ": ";
  const auto with_depth = std::count_if(recording.frames().begin(), recording.frames().end(),
                                        [](const io::FrameSample& frame) { return frame.depth.has_value(); });
  if (with_depth == 0) {
    findings.push_back(
        {true, file + "no depth image is within 20 ms of an image: are both stamped by the same clock?"});
    return;
  }
  if (2 * static_cast<std::size_t>(with_depth) < recording.frame_count())
    findings.push_back({false, file + format("%td of %zu images have a depth image within 20 ms, expected all",
                                             with_depth, recording.frame_count())});
  if (depths.read == 0 && !depths.unreadable.empty())
    findings.push_back({true, file + "no depth image looked at can be used: " + depths.unreadable});
  if (depths.read == 0) return;
  if (depths.raw.empty()) {
    findings.push_back({true, file + format("none of %d depth images looked at has a measurement", depths.read)});
    return;
  }
  if (const double part = depths.measured / depths.read; part < 0.05)
    findings.push_back(
        {false, file + format("depth is measured at %.2g %% of the pixels, expected 20 or more", 100 * part)});
  std::vector<double> raw = depths.raw;
  std::sort(raw.begin(), raw.end());
  const double middle = raw[raw.size() / 2], scale = recording.calibration().depth_scale, z = middle / scale;
  const pl::DepthSensor<double> sensor;
  if (z > sensor.z_min && z < sensor.z_max) return;
  std::string text = file + format("the median depth is %.3g m with the calibration's scale of %g, expected %g to %g m",
                                   z, scale, sensor.z_min, sensor.z_max);
  for (const double other : {scale / 100, scale * 100, scale / 10, scale * 10, 1000.0, 5000.0}) {
    if (middle / other > 0.5 && middle / other < 6) {
      text += format(": is it %g?", other);
      break;
    }
  }
  findings.push_back({z < sensor.z_min / 2 || z > 2 * sensor.z_max, text});
}

}  // namespace

std::vector<Finding> check_images(const io::Recording& recording, const Needs& needs) {
  Look look;
  Depths depths;
  for (const io::FrameSample& frame : some_of(recording.frames())) {
    try {
      look_at(io::read_gray(frame), look);
    } catch (const std::runtime_error&) {
      continue;
    }
    if (!needs.depth || !frame.depth) continue;
    try {
      look_at_depth(io::read_depth(frame), depths);
    } catch (const std::runtime_error& error) {
      if (depths.unreadable.empty()) depths.unreadable = error.what();
    }
  }
  std::vector<Finding> findings;
  check_look(recording.files().frame_index.string() + ": ", look, findings);
  if (needs.depth) check_depths(recording, depths, findings);
  return findings;
}
