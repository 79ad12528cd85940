#pragma once
/// Shi-Tomasi scores of a tile of pixels.                                              docs/math/tracking.md (11)
///
///   score = smallest eigenvalue of  1/49 sum g g^T  over 7x7 pixels,  g = central differences  [intensity^2/px^2] (11)
/// By sums over columns that slide down and sums over rows of those: the work does not depend on the texture. The sums
/// are exact (below 2^24), and all loops are of constant length, whole vectors with `-O2` too.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_view.hpp"

namespace plumbline {

class ScoreTile {
 public:
  static constexpr int size = 32;   ///< [px]
  static constexpr int margin = 4;  ///< pixels read around the tile
  using Row = Eigen::Array<float, size, 1>;

  /// Scores of the pixels from (x0, y0) on, of so many rows; the tile and its margin must be inside the image.
  void compute(const ImageView<const std::uint8_t>& image, int x0, int y0, int rows = size) {
    PLUMBLINE_ASSERT(x0 >= margin && y0 >= margin && x0 + size + margin <= image.width);
    PLUMBLINE_ASSERT(rows <= size && y0 + rows + margin <= image.height);
    const std::uint8_t* const first = image.data + (y0 - margin) * image.stride + x0 - margin;
    Pixels pixels[3];  // of three rows, in turn
    const auto load = [&](int row) { to_integers(first + row * image.stride, pixels[row % 3]); };
    load(0);
    load(1);
    Gradients last[window]{};
    Sums sums{};
    for (int y = 0; y < rows + window - 1; ++y) {
      load(y + 2);
      const Gradients now = gradients(pixels[y % 3], pixels[(y + 1) % 3], pixels[(y + 2) % 3]);
      Gradients& before = last[y % window];
      slide(now, before, sums);
      before = now;
      if (y >= window - 1) rows_[static_cast<std::size_t>(y - window + 1)] = score(sums);
    }
  }

  const Row& row(int y) const { return rows_[static_cast<std::size_t>(y)]; }

 private:
  static constexpr int window = 7;
  static constexpr int columns = 40;  ///< the last two mean nothing, and make whole vectors

  using Pixels = std::array<std::int16_t, 48>;  ///< of a row from the left margin on; 0 beyond the right one
  /// Of a row, twice the central differences [intensity].
  struct Gradients {
    std::array<std::int16_t, columns> x, y;
  };
  /// Over the 7 rows of each column.
  struct Sums {
    std::array<std::int32_t, columns> xx, xy, yy;
  };

  static void to_integers(const std::uint8_t* row, Pixels& out) {
    std::array<std::uint8_t, std::tuple_size_v<Pixels>> bytes{};
    std::copy_n(row, size + 2 * margin, bytes.data());
    for (std::size_t x = 0; x < bytes.size(); ++x) out[x] = bytes[x];
  }
  static Gradients gradients(const Pixels& above, const Pixels& here, const Pixels& below) {
    Gradients out;
    for (std::size_t x = 0; x < columns; ++x) {
      out.x[x] = static_cast<std::int16_t>(here[x + 2] - here[x]);
      out.y[x] = static_cast<std::int16_t>(below[x + 1] - above[x + 1]);
    }
    return out;
  }

  /// One row more, one less: a a - b b = (a + b) (a - b).
  static void slide(const Gradients& now, const Gradients& before, Sums& sums) {
    for (std::size_t x = 0; x < columns; ++x) {
      const std::int16_t plus = static_cast<std::int16_t>(now.x[x] + before.x[x]);
      const std::int16_t minus = static_cast<std::int16_t>(now.x[x] - before.x[x]);
      sums.xx[x] += plus * minus;
    }
    for (std::size_t x = 0; x < columns; ++x) {
      const std::int16_t plus = static_cast<std::int16_t>(now.y[x] + before.y[x]);
      const std::int16_t minus = static_cast<std::int16_t>(now.y[x] - before.y[x]);
      sums.yy[x] += plus * minus;
    }
    for (std::size_t x = 0; x < columns; ++x) sums.xy[x] += now.x[x] * now.y[x] - before.x[x] * before.y[x];
  }

  static Row seven(const std::array<std::int32_t, columns>& one) {
    constexpr std::size_t pairs = size + 4;
    std::array<std::int32_t, pairs> two;
    for (std::size_t x = 0; x < pairs; ++x) two[x] = one[x] + one[x + 1];
    Row out;
    float* const sum = out.data();
    for (std::size_t x = 0; x < size; ++x) sum[x] = static_cast<float>(two[x] + two[x + 2] + two[x + 4] + one[x + 6]);
    return out;
  }

  /// Smallest eigenvalues.
  static Row score(const Sums& sums) {
    const Row xx = seven(sums.xx), xy = seven(sums.xy), yy = seven(sums.yy);
    constexpr float scale = 1.0f / (4 * window * window);  // 4: g are halves of the differences above
    return scale * (0.5f * (xx + yy) - ((0.5f * (xx - yy)).square() + xy.square()).sqrt());
  }

  std::array<Row, size> rows_;
};

}  // namespace plumbline
