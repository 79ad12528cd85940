#include "plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "axis.hpp"
#include "misuse.hpp"
#include "plumbline/io/output_file.hpp"

namespace io = plumbline::io;

namespace {

// Everything is drawn at twice its size and scaled down at the end: smooth lines and letters.
constexpr int zoom = 2;
constexpr int width = 1100, height = 820;                    // [px]
constexpr int left = 70, right = 30, top = 70, bottom = 60;  // margins [px]

const cv::Scalar ink(60, 60, 60), faint(228, 228, 228), pale(190, 190, 190), gray(140, 140, 140), black(40, 40, 40);
const cv::Scalar green(60, 150, 40), red(50, 50, 210);
/// Of the first estimate, the second ... (blue, orange, green, purple, red, brown), and again.
const std::array<cv::Scalar, 6> curve_colors{cv::Scalar(200, 110, 20), {20, 120, 230}, {70, 150, 40},
                                             {170, 70, 130},           {50, 50, 210},  {60, 90, 130}};
const cv::Scalar& color_of_curve(std::size_t i) { return curve_colors[i % curve_colors.size()]; }

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

View view_of(const std::vector<const io::Trajectory*>& trajectories) {
  using Vec3 = plumbline::Vec<double, 3>;
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const io::Trajectory* trajectory : trajectories)
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

/// Calls draw(value, label) for each line of a grid; none where the range is beyond what numbers resolve.
template <class Draw>
void for_each_grid_line(double low, double high, double step, Draw&& draw) {
  const double first = std::ceil(low / step);
  constexpr int most = 100;
  for (int i = 0; i < most && (first + i) * step < high; ++i)
    draw((first + i) * step, grid_label((first + i) * step, step));
}

void draw_grid(cv::Mat& picture, const View& view) {
  const double step = grid_step(view.high_x - view.low_x, 9);
  for_each_grid_line(view.low_x, view.high_x, step, [&](double x, const std::string& text) {
    const cv::Point foot = view.at(x, view.low_y);
    cv::line(picture, foot, view.at(x, view.high_y), faint, zoom, cv::LINE_AA);
    write(picture, text, {foot.x - text_size(text, 0.42).width / 2, foot.y + zoom * 20}, 0.42);
  });
  for_each_grid_line(view.low_y, view.high_y, step, [&](double y, const std::string& text) {
    const cv::Point foot = view.at(view.low_x, y);
    cv::line(picture, foot, view.at(view.high_x, y), faint, zoom, cv::LINE_AA);
    const cv::Size size = text_size(text, 0.42);
    write(picture, text, {foot.x - size.width - zoom * 8, foot.y + size.height / 2}, 0.42);
  });
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

/// From right to left; the first name is leftmost.
struct Legend {
  cv::Mat& picture;
  int right_end = zoom * (width - right);

  void line(const std::string& name, const cv::Scalar& color, int thickness) {
    right_end -= text_size(name, 0.5).width + zoom * 58;
    const int y = zoom * (top - 20);
    cv::line(picture, {right_end, y}, {right_end + zoom * 28, y}, color, zoom * thickness, cv::LINE_AA);
    write(picture, name, {right_end + zoom * 36, y + zoom * 5}, 0.5);
  }
  void start_and_end() {
    right_end -= zoom * 130;
    const int x = right_end, y = zoom * (top - 20);
    cv::circle(picture, {x, y}, zoom * 6, green, cv::FILLED, cv::LINE_AA);
    write(picture, "start", {x + zoom * 12, y + zoom * 5}, 0.5);
    cv::rectangle(picture, {x + zoom * 75, y - zoom * 5}, {x + zoom * 85, y + zoom * 5}, red, cv::FILLED, cv::LINE_AA);
    write(picture, "end", {x + zoom * 92, y + zoom * 5}, 0.5);
  }
};

cv::Mat blank_picture() { return {zoom * height, zoom * width, CV_8UC3, cv::Scalar::all(255)}; }

void save(const std::filesystem::path& file, const cv::Mat& drawn) {
  require_picture_name(file);
  cv::Mat picture;
  cv::resize(drawn, picture, {width, height}, 0, 0, cv::INTER_AREA);
  std::vector<unsigned char> bytes;
  cv::imencode(file.extension().string(), picture, bytes);
  io::OutputFile out(file);
  out.stream().write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.commit();
}

}  // namespace

void require_picture_name(const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  if (extension != ".png" && extension != ".jpg")
    throw Misuse(file.string() + ": a picture's name must end with .png or .jpg");
}

void draw_trajectories(const std::filesystem::path& file, const io::Trajectory& reference,
                       const std::vector<NamedTrajectory>& estimates, const std::string& title) {
  std::vector<const io::Trajectory*> all{&reference};
  plumbline::TimeNs first = std::numeric_limits<plumbline::TimeNs>::max(),
                    last = std::numeric_limits<plumbline::TimeNs>::min();
  for (const NamedTrajectory& estimate : estimates) {
    if (estimate.poses.empty()) throw std::runtime_error(file.string() + ": nothing to draw");
    all.push_back(&estimate.poses);
    first = std::min(first, estimate.poses.front().t_ns);
    last = std::max(last, estimate.poses.back().t_ns);
  }
  io::Trajectory covered;
  for (const io::StampedPose& pose : reference)
    if (pose.t_ns >= first && pose.t_ns <= last) covered.push_back(pose);

  cv::Mat picture = blank_picture();
  const View view = view_of(all);
  draw_grid(picture, view);
  draw_path(picture, view, reference, pale, 1);
  draw_path(picture, view, covered, gray, 4);
  for (std::size_t i = 0; i < estimates.size(); ++i) draw_path(picture, view, estimates[i].poses, color_of_curve(i), 2);
  for (const NamedTrajectory& estimate : estimates) draw_marks(picture, view, estimate.poses);
  Legend legend{picture};
  legend.start_and_end();
  for (std::size_t i = estimates.size(); i-- > 0;) legend.line(estimates[i].name, color_of_curve(i), 2);
  if (!reference.empty()) legend.line("reference", gray, 4);
  write(picture, title, {zoom * left, zoom * 26}, 0.6, black);
  save(file, picture);
}

void draw_trajectories(const std::filesystem::path& file, const io::Trajectory& reference,
                       const io::Trajectory& estimate, const std::string& title) {
  draw_trajectories(file, reference, std::vector<NamedTrajectory>{{"estimate", estimate}}, title);
}

void draw_errors(const std::filesystem::path& file, const std::vector<ErrorCurve>& curves, const std::string& title) {
  plumbline::TimeNs first = std::numeric_limits<plumbline::TimeNs>::max(),
                    last = std::numeric_limits<plumbline::TimeNs>::min();
  double largest_error_m = 1e-9;
  for (const ErrorCurve& curve : curves)
    for (const io::StampedError& error : curve.errors) {
      first = std::min(first, error.t_ns);
      last = std::max(last, error.t_ns);
      largest_error_m = std::max(largest_error_m, error.position_m);
    }
  const double duration_s = std::max(1e-3, plumbline::seconds_between(first, last)), top_m = 1.05 * largest_error_m;
  const auto at = [&](double t_s, double m) {
    return cv::Point(cvRound(zoom * (left + (width - left - right) * t_s / duration_s)),
                     cvRound(zoom * (height - bottom - (height - top - bottom) * m / top_m)));
  };

  cv::Mat picture = blank_picture();
  for_each_grid_line(0, duration_s, grid_step(duration_s, 10), [&](double t_s, const std::string& text) {
    cv::line(picture, at(t_s, 0), at(t_s, top_m), faint, zoom, cv::LINE_AA);
    write(picture, text, at(t_s, 0) + cv::Point(-text_size(text, 0.42).width / 2, zoom * 20), 0.42);
  });
  for_each_grid_line(0, top_m, grid_step(top_m, 8), [&](double m, const std::string& text) {
    const cv::Size size = text_size(text, 0.42);
    cv::line(picture, at(0, m), at(duration_s, m), faint, zoom, cv::LINE_AA);
    write(picture, text, at(0, m) + cv::Point(-size.width - zoom * 8, size.height / 2), 0.42);
  });
  cv::rectangle(picture, at(0, 0), at(duration_s, top_m), pale, zoom, cv::LINE_AA);
  write(picture, "time [s]", {zoom * (width / 2 - 25), zoom * (height - 14)}, 0.5);
  write(picture, "position error [m]", {zoom * 16, zoom * (top - 14)}, 0.5);

  Legend legend{picture};
  for (std::size_t i = curves.size(); i-- > 0;) {
    std::vector<std::vector<cv::Point>> strokes(1);
    const std::vector<io::StampedError>& errors = curves[i].errors;
    for (std::size_t k = 0; k < errors.size(); ++k) {
      const bool is_gap =
          k > 0 && plumbline::seconds_between(errors[k - 1].t_ns, errors[k].t_ns) > std::max(1.0, duration_s / 50);
      if (is_gap) strokes.emplace_back();
      strokes.back().push_back(at(plumbline::seconds_between(first, errors[k].t_ns), errors[k].position_m));
    }
    cv::polylines(picture, strokes, false, color_of_curve(i), zoom * 2, cv::LINE_AA);
    legend.line(curves[i].name, color_of_curve(i), 2);
  }
  write(picture, title, {zoom * left, zoom * 26}, 0.6, black);
  save(file, picture);
}
