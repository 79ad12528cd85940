#include "plumbline/tracking/corner_score.hpp"

#include "catch.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "tracking/corner_definitions.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;

TEST_CASE("corner score: as it is defined, up to the corners of a tight image") {
  constexpr int side = ScoreTile::size + 2 * ScoreTile::margin;
  const auto check = [](const cv::Mat& image, int rows) {
    const testing::GrayView view = opencv::view<std::uint8_t>(image);
    ScoreTile tile;
    tile.compute(view, ScoreTile::margin, ScoreTile::margin, rows);
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < ScoreTile::size; ++x) {
        const double expected = testing::shi_tomasi(view, x + ScoreTile::margin, y + ScoreTile::margin);
        REQUIRE(tile.row(y)[x] == Approx(expected).epsilon(1e-3).margin(1e-3));
      }
    }
  };
  check(testing::with_noise(testing::textured_image(side, side), 20.0, 3), ScoreTile::size);
  check(testing::with_noise(testing::textured_image(side, side - 7), 20.0, 4), ScoreTile::size - 7);
  cv::Mat steepest(side, side, CV_8U);  // the largest sums
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) steepest.at<std::uint8_t>(y, x) = (x / 2 + y / 2) % 2 == 0 ? 0 : 255;
  }
  check(steepest, ScoreTile::size);
}
