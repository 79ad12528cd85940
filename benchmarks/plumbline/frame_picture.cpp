#include "frame_picture.hpp"

#include <array>
#include <cmath>
#include <utility>

#include <opencv2/imgproc.hpp>

namespace {

using Pixel = plumbline::Vec<float, 2>;

const std::array<cv::Scalar, mark_states> state_colors{cv::Scalar(70, 210, 60), cv::Scalar(240, 170, 40),
                                                       cv::Scalar(50, 50, 240), cv::Scalar(30, 210, 240)};
const cv::Scalar text_color(235, 235, 235);
constexpr int strip_px = 62;  // below the image
constexpr int shift = 4;      // subpixel bits of OpenCV's coordinates
constexpr double text_scale = 0.42;

const cv::Scalar& color_of(MarkState state) { return state_colors[static_cast<std::size_t>(state)]; }

/// Marks in the picture, which shows the image `zoom` times as large.
class Pen {
 public:
  Pen(cv::Mat& picture, int zoom) : picture_(picture), zoom_(static_cast<float>(zoom)) {}

  void line(const Pixel& a, const Pixel& b, const cv::Scalar& color, int thickness = 1) const {
    cv::line(picture_, at(a), at(b), color, thickness, cv::LINE_AA, shift);
  }
  void circle(const Pixel& center, float radius_px, const cv::Scalar& color) const {
    cv::circle(picture_, at(center), cvRound(radius_px * (1 << shift)), color, 1, cv::LINE_AA, shift);
  }
  void cross(const Pixel& center, const cv::Scalar& color) const {
    const float arm = 3.5f / zoom_;
    line(center - Pixel(arm, arm), center + Pixel(arm, arm), color);
    line(center - Pixel(arm, -arm), center + Pixel(arm, -arm), color);
  }

 private:
  cv::Point at(const Pixel& p) const {
    const Pixel q = (zoom_ * (p + Pixel(0.5f, 0.5f)) - Pixel(0.5f, 0.5f)) * static_cast<float>(1 << shift);
    return {cvRound(q.x()), cvRound(q.y())};
  }

  cv::Mat& picture_;
  float zoom_;
};

void draw_point(const Pen& pen, const Mark& mark, const cv::Scalar& color) {
  if (mark.before) pen.line(mark.now.start, mark.before->start, color);
  if (mark.state == MarkState::located || mark.state == MarkState::unlocated) {
    pen.circle(mark.now.start, 3, color);
  } else {
    pen.cross(mark.now.start, color);
  }
}

/// Its tail goes across the edge: along it nothing is known to have moved.
void draw_line(const Pen& pen, const Mark& mark, const cv::Scalar& color) {
  const Pixel middle = (mark.now.start + mark.now.end) / 2;
  pen.line(mark.now.start, mark.now.end, color, mark.state == MarkState::located ? 2 : 1);
  if (mark.state == MarkState::rejected || mark.state == MarkState::lost) pen.cross(middle, color);
  if (!mark.before) return;
  const Pixel along = (mark.before->end - mark.before->start).normalized();
  pen.line(middle, mark.before->start + along.dot(middle - mark.before->start) * along, color);
}

int write(cv::Mat& picture, const std::string& text, cv::Point at, const cv::Scalar& color) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, text_scale, color, 1, cv::LINE_AA);
  return at.x + cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, text_scale, 1, nullptr).width;
}

/// "points 120 located 14 unlocated 9 rejected 5 lost".
void write_counts(cv::Mat& picture, const char* kind, const std::vector<Mark>& marks, cv::Point at) {
  const std::array<int, mark_states> counts = count_states(marks);
  at.x = write(picture, kind, at, text_color) + 8;
  for (std::size_t i = 0; i < mark_states; ++i)
    at.x = write(picture, std::to_string(counts[i]) + " " + mark_state_names[i], at, state_colors[i]) + 8;
}

}  // namespace

cv::Mat frame_picture(const cv::Mat& gray, const std::vector<Mark>& marks, const std::string& headline) {
  constexpr int narrowest = 640;  // [px], for the text
  const int zoom = (narrowest + gray.cols - 1) / gray.cols;
  cv::Mat picture(zoom * gray.rows + strip_px, zoom * gray.cols, CV_8UC3, cv::Scalar::all(25));
  cv::Mat image = picture.rowRange(0, zoom * gray.rows), enlarged;
  cv::resize(gray, enlarged, {}, zoom, zoom, cv::INTER_NEAREST);
  cv::cvtColor(enlarged, image, cv::COLOR_GRAY2BGR);

  const Pen pen(image, zoom);
  std::vector<Mark> points, lines;
  for (const Mark& mark : marks) {
    (mark.is_line ? lines : points).push_back(mark);
    mark.is_line ? draw_line(pen, mark, color_of(mark.state)) : draw_point(pen, mark, color_of(mark.state));
  }
  cv::Point at(8, image.rows + 17);
  write(picture, headline, at, text_color);
  for (const auto& [kind, of_kind] : {std::pair("points", &points), std::pair("lines", &lines)})
    if (!of_kind->empty()) write_counts(picture, kind, *of_kind, at += cv::Point(0, 19));
  return picture;
}
