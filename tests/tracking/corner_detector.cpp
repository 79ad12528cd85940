#include "plumbline/tracking/corner_detector.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "catch.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "tracking/corner_definitions.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;
using testing::is_fast_corner;
using testing::shi_tomasi;
using testing::Vec2f;
using View = testing::GrayView;

namespace {

/// The best corner of every cell by exhaustive search, in the order of the cells.
std::vector<Corner> reference_corners(const View& image, const std::vector<Vec2f>& existing,
                                      const CornerOptions& options) {
  std::vector<Corner> found;
  const float distance = 0.5f * float(options.cell_px);
  const int right = image.width - options.border_px, bottom = image.height - options.border_px;
  for (int y0 = options.border_px; y0 < bottom; y0 += options.cell_px) {
    for (int x0 = options.border_px; x0 < right; x0 += options.cell_px) {
      const int x1 = std::min(x0 + options.cell_px, right), y1 = std::min(y0 + options.cell_px, bottom);
      const bool occupied = std::any_of(existing.begin(), existing.end(), [&](const Vec2f& uv) {
        return uv.x() > float(x0) - 0.5f && uv.x() < float(x1) - 0.5f && uv.y() > float(y0) - 0.5f &&
               uv.y() < float(y1) - 0.5f;
      });
      if (occupied) continue;
      std::optional<Corner> best;
      double best_score = 0;
      for (const int threshold : {options.fast_threshold, options.fast_threshold_low, -1}) {
        for (int y = y0; y < y1; ++y) {
          for (int x = x0; x < x1; ++x) {
            const Vec2f uv{float(x), float(y)};
            const double score = shi_tomasi(image, x, y);
            const auto is_near = [&](const Vec2f& other) { return (other - uv).norm() < distance; };
            if (score < double(options.min_score) || !(score > best_score)) continue;
            if (threshold >= 0 && !is_fast_corner(image, x, y, threshold)) continue;
            if (std::any_of(existing.begin(), existing.end(), is_near)) continue;
            if (std::any_of(found.begin(), found.end(), [&](const Corner& c) { return is_near(c.uv); })) continue;
            best_score = score;
            best = Corner{uv, float(score), 0};
          }
        }
        if (best) break;
      }
      if (best) found.push_back(*best);
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const Corner& a, const Corner& b) { return a.score > b.score; });
  return found;
}

using Many = FixedVector<Corner, 1000>;

std::vector<cv::Mat> images() {
  std::vector<cv::Mat> out{testing::with_noise(testing::textured_image(200, 150), 2.0, 3)};
  for (const cv::Mat& image : testing::recorded_images()) {
    out.push_back(image(cv::Rect(image.cols / 4, image.rows / 4, 211, 163)).clone());
  }
  // nearly white: contrast below both thresholds
  cv::Mat faint;
  testing::textured_image(220, 180, 8).convertTo(faint, CV_8U, 0.06, 220);
  out.push_back(faint);
  return out;
}

}  // namespace

TEST_CASE("corner detector: equals the exhaustive search") {
  for (const cv::Mat& image : images()) {
    const View view = opencv::view<std::uint8_t>(image);
    for (const int cell_px : {30, 32, 41, 70}) {
      CornerOptions options;
      options.cell_px = cell_px;
      const std::vector<Vec2f> existing{Vec2f(60.2f, 50.7f), Vec2f(100.0f, 90.0f), Vec2f(5.0f, 70.0f),
                                        Vec2f(103.0f, 91.0f)};
      const std::vector<Corner> expected = reference_corners(view, existing, options);
      auto found = std::make_unique<Many>();
      detect_corners(view, existing.data(), existing.size(), options, *found);
      REQUIRE(found->size() == expected.size());
      for (std::size_t i = 0; i < expected.size(); ++i) {
        INFO(i << ": " << (*found)[i].uv.transpose() << " score " << (*found)[i].score << " not "
               << expected[i].uv.transpose() << " score " << expected[i].score);
        REQUIRE((*found)[i].uv == expected[i].uv);
        REQUIRE((*found)[i].score == Approx(expected[i].score).epsilon(1e-3).margin(1e-3));
      }
    }
  }
}

TEST_CASE("corner detector: keeps its distance, order and border, and appends") {
  const cv::Mat image = testing::with_noise(testing::textured_image(), 2.0, 3);
  const View view = opencv::view<std::uint8_t>(image);
  auto corners = std::make_unique<Many>();
  const CornerOptions options;
  detect_corners(view, nullptr, 0, options, *corners);
  REQUIRE(corners->size() > 200);
  std::vector<Vec2f> existing;
  for (std::size_t i = 0; i < corners->size(); ++i) {
    const Corner& corner = (*corners)[i];
    REQUIRE(view.contains(corner.uv.x(), corner.uv.y(), float(options.border_px)));
    if (i > 0) REQUIRE(corner.score <= (*corners)[i - 1].score);
    for (std::size_t j = 0; j < i; ++j) REQUIRE((corner.uv - (*corners)[j].uv).norm() >= 15.0f);
    if (i % 2 == 0) existing.push_back(corner.uv);
  }
  auto more = std::make_unique<Many>();
  more->push_back(Corner{Vec2f(1, 1), 1e9f, 3});
  detect_corners(view, existing.data(), existing.size(), options, *more);
  REQUIRE((*more)[0].level == 3);
  REQUIRE(more->size() > 20);
  for (std::size_t i = 1; i < more->size(); ++i) {
    for (const Vec2f& uv : existing) REQUIRE(((*more)[i].uv - uv).norm() >= 15.0f);
  }
}

TEST_CASE("corner detector: a small vector gets the strongest") {
  const cv::Mat image = testing::with_noise(testing::textured_image(), 2.0, 3);
  const View view = opencv::view<std::uint8_t>(image);
  auto all = std::make_unique<Many>();
  detect_corners(view, nullptr, 0, CornerOptions{}, *all);
  FixedVector<Corner, 20> few;
  detect_corners(view, nullptr, 0, CornerOptions{}, few);
  REQUIRE(few.size() == 20);
  for (std::size_t i = 0; i < few.size(); ++i) REQUIRE(few[i].score >= (*all)[i].score);
  detect_corners(view, nullptr, 0, CornerOptions{}, few);  // full: nothing changes
  REQUIRE(few.size() == 20);
}

TEST_CASE("corner detector: weak corners of a nearly white image, nothing in a flat or noisy one") {
  cv::Mat faint(240, 320, CV_8U, cv::Scalar(235));
  faint(cv::Rect(100, 80, 90, 70)).setTo(229);  // four corners of contrast 6, below the low threshold
  auto corners = std::make_unique<Many>();
  CornerOptions options;
  options.min_score = 0.3f;
  detect_corners(opencv::view<std::uint8_t>(faint), nullptr, 0, options, *corners);
  for (const Vec2f& truth : {Vec2f(99.5f, 79.5f), Vec2f(189.5f, 79.5f), Vec2f(99.5f, 149.5f), Vec2f(189.5f, 149.5f)}) {
    REQUIRE(
        std::any_of(corners->begin(), corners->end(), [&](const Corner& c) { return (c.uv - truth).norm() < 4.0f; }));
  }
  for (const double sigma : {0.0, 1.0}) {
    corners->clear();
    const cv::Mat flat = testing::with_noise(cv::Mat(240, 320, CV_8U, cv::Scalar(128)), sigma, 4);
    detect_corners(opencv::view<std::uint8_t>(flat), nullptr, 0, CornerOptions{}, *corners);
    REQUIRE(corners->empty());
  }
}

TEST_CASE("corner detector: images too small give nothing") {
  const cv::Mat image = testing::textured_image();
  for (const auto& [width, height] : {std::pair(39, 200), std::pair(200, 39), std::pair(0, 0)}) {
    FixedVector<Corner, 10> corners;
    View view = opencv::view<std::uint8_t>(image);
    view.width = width;
    view.height = height;
    detect_corners(view, nullptr, 0, CornerOptions{}, corners);
    REQUIRE(corners.empty());
  }
}

TEST_CASE("corner detector: none where a mask excludes, all others as without it") {
  const cv::Mat image = testing::with_noise(testing::textured_image(), 2.0, 3);
  cv::Mat used(image.size(), CV_8U, cv::Scalar(255));
  used.rowRange(image.rows / 2, image.rows).setTo(0);
  const auto mask = std::make_unique<ImageMask<640 * 480>>();
  REQUIRE(mask->set(opencv::view<std::uint8_t>(used)));
  CornerOptions options;
  options.cell_px = 29;  // a row of cells is cut by the mask
  const auto masked = std::make_unique<Many>(), all = std::make_unique<Many>();
  detect_corners(opencv::view<std::uint8_t>(image), nullptr, 0, options, *masked, mask->view());
  detect_corners(opencv::view<std::uint8_t>(image), nullptr, 0, options, *all);
  const auto is_in = [](const Many& corners, const Vec2f& uv) {
    return std::any_of(corners.begin(), corners.end(), [&](const Corner& c) { return c.uv == uv; });
  };
  REQUIRE(masked->size() > 50);
  float lowest = 0;
  for (const Corner& corner : *masked) {
    REQUIRE_FALSE(mask->view().excludes(corner.uv));
    lowest = std::max(lowest, corner.uv.y());
  }
  REQUIRE(lowest > float(image.rows / 2 - ImageMask<1>::margin_px - options.cell_px));
  for (const Corner& corner : *all) {
    if (corner.uv.y() < float(image.rows / 2 - ImageMask<1>::margin_px - 2 * options.cell_px))
      REQUIRE(is_in(*masked, corner.uv));
  }
}
