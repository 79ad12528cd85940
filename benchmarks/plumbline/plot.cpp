#include "plot.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "axis.hpp"

namespace io = plumbline::io;

namespace {

// Everything is drawn at twice its size and scaled down at the end: smooth lines and letters.
constexpr int zoom = 2;
constexpr int width = 1100, height = 820;                    // [px]
constexpr int left = 70, right = 30, top = 70, bottom = 60;  // margins [px]

const cv::Scalar ink(60, 60, 60), faint(228, 228, 228), pale(190, 190, 190), gray(140, 140, 140), black(40, 40, 40),
    blue(200, 110, 20);
const cv::Scalar green(60, 150, 40), red(50, 50, 210);

/// World to picture: two of the axes, equal scale, the second axis up.
struct View {
  int axis_x = 0, axis_y = 1;
  double low_x = 0, low_y = 0, high_x = 1, high_y = 1;  // what the frame shows [m]
  double px_per_m = 1;

  cv::Point at(double x, double y) const {
    return {cvRound(zoom * (left + (x - low_x) * px_per_m)),
            cvRound(zoom * (height - bottom - (y - low_y) * px_per_m))};
  }
  cv::Point at(const io::StampedPose& pose) const {
    return at(pose.T_world_body.p()[axis_x], pose.T_world_body.p()[axis_y]);
  }
};

View view_of(const io::Trajectory& a, const io::Trajectory& b) {
  using Vec3 = plumbline::Vec<double, 3>;
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const io::Trajectory* trajectory : {&a, &b})
    for (const io::StampedPose& pose : *trajectory) {
      low = low.cwiseMin(pose.T_world_body.p());
      high = high.cwiseMax(pose.T_world_body.p());
    }
  const Vec3 extent = high - low;
  int smallest = 2;  // z, unless another axis is clearly flatter
  for (const int axis : {0, 1})
    if (extent[axis] < 0.8 * extent[smallest]) smallest = axis;
  View view;
  view.axis_x = smallest == 0 ? 1 : 0;
  view.axis_y = smallest == 2 ? 1 : 2;
  const double size_x = std::max(extent[view.axis_x], 1e-3), size_y = std::max(extent[view.axis_y], 1e-3);
  const double frame_x = width - left - right, frame_y = height - top - bottom;
  view.px_per_m = 0.9 * std::min(frame_x / size_x, frame_y / size_y);
  const double middle_x = (low[view.axis_x] + high[view.axis_x]) / 2,
               middle_y = (low[view.axis_y] + high[view.axis_y]) / 2;
  view.low_x = middle_x - frame_x / view.px_per_m / 2;
  view.high_x = middle_x + frame_x / view.px_per_m / 2;
  view.low_y = middle_y - frame_y / view.px_per_m / 2;
  view.high_y = middle_y + frame_y / view.px_per_m / 2;
  return view;
}

cv::Size text_size(const std::string& text, double scale) {
  return cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, zoom * scale, zoom, nullptr);
}

void write(cv::Mat& picture, const std::string& text, cv::Point at, double scale, const cv::Scalar& color = ink) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, zoom * scale, color, zoom, cv::LINE_AA);
}

void draw_grid(cv::Mat& picture, const View& view) {
  const double step = grid_step(view.high_x - view.low_x, 9);
  for (double x = std::ceil(view.low_x / step) * step; x < view.high_x; x += step) {
    const cv::Point foot = view.at(x, view.low_y);
    cv::line(picture, foot, view.at(x, view.high_y), faint, zoom, cv::LINE_AA);
    const std::string text = grid_label(x, step);
    write(picture, text, {foot.x - text_size(text, 0.42).width / 2, foot.y + zoom * 20}, 0.42);
  }
  for (double y = std::ceil(view.low_y / step) * step; y < view.high_y; y += step) {
    const cv::Point foot = view.at(view.low_x, y);
    cv::line(picture, foot, view.at(view.high_x, y), faint, zoom, cv::LINE_AA);
    const std::string text = grid_label(y, step);
    const cv::Size size = text_size(text, 0.42);
    write(picture, text, {foot.x - size.width - zoom * 8, foot.y + size.height / 2}, 0.42);
  }
  cv::rectangle(picture, view.at(view.low_x, view.low_y), view.at(view.high_x, view.high_y), pale, zoom, cv::LINE_AA);
  const std::string names[] = {"x [m]", "y [m]", "z [m]"};
  write(picture, names[view.axis_x], {zoom * (width / 2 - 15), zoom * (height - 14)}, 0.5);
  write(picture, names[view.axis_y], {zoom * 16, zoom * (top - 14)}, 0.5);
}

/// A line through the poses, broken where poses are missing for long.
void draw_path(cv::Mat& picture, const View& view, const io::Trajectory& trajectory, const cv::Scalar& color,
               int thickness) {
  std::vector<plumbline::TimeNs> gaps;
  for (std::size_t i = 1; i < trajectory.size(); ++i) gaps.push_back(trajectory[i].t_ns - trajectory[i - 1].t_ns);
  if (gaps.empty()) return;
  std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2), gaps.end());
  const plumbline::TimeNs long_gap = std::max<plumbline::TimeNs>(10 * gaps[gaps.size() / 2], 1'000'000'000);
  std::vector<std::vector<cv::Point>> strokes(1);
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    if (i > 0 && trajectory[i].t_ns - trajectory[i - 1].t_ns > long_gap) strokes.emplace_back();
    strokes.back().push_back(view.at(trajectory[i]));
  }
  cv::polylines(picture, strokes, false, color, zoom * thickness, cv::LINE_AA);
}

void draw_marks(cv::Mat& picture, const View& view, const io::Trajectory& trajectory) {
  const cv::Point begin = view.at(trajectory.front()), end = view.at(trajectory.back()), half(zoom * 6, zoom * 6);
  cv::circle(picture, begin, zoom * 7, green, cv::FILLED, cv::LINE_AA);
  cv::rectangle(picture, end - half, end + half, red, cv::FILLED, cv::LINE_AA);
}

void draw_legend(cv::Mat& picture, bool with_reference) {
  const int y = zoom * (top - 20);
  int x = zoom * (width - right - 400);
  const auto line = [&](const char* name, const cv::Scalar& color, int thickness) {
    cv::line(picture, {x, y}, {x + zoom * 28, y}, color, zoom * thickness, cv::LINE_AA);
    write(picture, name, {x + zoom * 36, y + zoom * 5}, 0.5);
    x += zoom * 130;
  };
  if (with_reference) line("reference", gray, 4);
  line("estimate", blue, 2);
  cv::circle(picture, {x, y}, zoom * 6, green, cv::FILLED, cv::LINE_AA);
  write(picture, "start", {x + zoom * 12, y + zoom * 5}, 0.5);
  x += zoom * 80;
  cv::rectangle(picture, {x - zoom * 5, y - zoom * 5}, {x + zoom * 5, y + zoom * 5}, red, cv::FILLED, cv::LINE_AA);
  write(picture, "end", {x + zoom * 12, y + zoom * 5}, 0.5);
}

}  // namespace

void draw_trajectories(const std::filesystem::path& png, const io::Trajectory& reference,
                       const io::Trajectory& estimate, const std::string& title) {
  if (estimate.empty()) throw std::runtime_error(png.string() + ": nothing to draw");
  io::Trajectory covered;
  for (const io::StampedPose& pose : reference)
    if (pose.t_ns >= estimate.front().t_ns && pose.t_ns <= estimate.back().t_ns) covered.push_back(pose);

  cv::Mat picture(zoom * height, zoom * width, CV_8UC3, cv::Scalar::all(255));
  const View view = view_of(reference, estimate);
  draw_grid(picture, view);
  draw_path(picture, view, reference, pale, 1);
  draw_path(picture, view, covered, gray, 4);
  draw_path(picture, view, estimate, blue, 2);
  draw_marks(picture, view, estimate);
  draw_legend(picture, !reference.empty());
  write(picture, title, {zoom * left, zoom * 26}, 0.6, black);
  cv::resize(picture, picture, {width, height}, 0, 0, cv::INTER_AREA);
  if (!cv::imwrite(png.string(), picture)) throw std::runtime_error(png.string() + ": cannot be written");
}
