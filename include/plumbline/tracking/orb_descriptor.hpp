#pragma once
/// Oriented binary descriptor of a point: 256 comparisons of the smoothed patch around it, in a pattern that turns with
/// the patch.                                                                     docs/math/place_recognition.md
///
///   m_10 = sum x I(x, y),  m_01 = sum y I(x, y)   over the disc x^2 + y^2 <= 15^2 around the point
///   theta = atan2(m_01, m_10)                                                                                   (4)
///   J = g * I,  g = Gaussian of 7x7 px, sigma 2 px                                                              (5)
///   bit i = J(R(theta) p_i) < J(R(theta) q_i),  positions rounded to pixels                                     (6)
/// The point itself is rounded to a pixel of its level. Work per point is constant: the patch is smoothed alone, and no
/// smoothed image is stored.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/tracking/binary_descriptor.hpp"
#include "plumbline/tracking/orb_pattern.hpp"

namespace plumbline {

struct OrbDescription {
  bool valid = false;   ///< false: nearer to the image's edge than `OrbDescriber::border_px`
  float angle_rad = 0;  ///< theta (4), from the x axis to the y axis
  BinaryDescriptor descriptor;
};

class OrbDescriber {
 public:
  static constexpr int border_px = OrbPattern::radius + 3;  ///< the pattern and half of the Gaussian

  /// At `uv` [px of this image].
  static OrbDescription describe(const ImageView<const std::uint8_t>& image, const Vec<float, 2>& uv) {
    OrbDescription out;
    constexpr float border = static_cast<float>(border_px);
    if (image.empty() || !image.contains(uv.x(), uv.y(), border)) return out;  // false for NaN too
    const int x = static_cast<int>(uv.x() + 0.5f), y = static_cast<int>(uv.y() + 0.5f);
    const std::uint8_t* const center = image.data + y * image.stride + x;
    out.valid = true;
    const Vec<float, 2> m = centroid(center, image.stride);
    out.angle_rad = elementary::atan2(m.y(), m.x());
    const float norm = std::sqrt(squared_norm(m));
    // A patch without a direction keeps the axes of the image.
    out.descriptor =
        norm > 0 ? compare(center, image.stride, m.x() / norm, m.y() / norm) : compare(center, image.stride, 1, 0);
    return out;
  }

 private:
  static constexpr int radius = OrbPattern::radius, side = 2 * radius + 1, taps = 7;
  static constexpr int rows = side + taps - 1;
  static constexpr int width = 32;  ///< of a row in memory: whole vectors; the last column is not used
  using Smoothed = std::array<std::uint16_t, static_cast<std::size_t>(side* width)>;

  /// (m_10, m_01) of (4)
  static Vec<float, 2> centroid(const std::uint8_t* center, std::ptrdiff_t stride) {
    // Half widths of the rows of the disc.
    constexpr std::array<int, radius + 1> half = {15, 14, 14, 14, 14, 14, 13, 13, 12, 12, 11, 10, 9, 7, 5, 0};
    int m10 = 0, m01 = 0;
    for (int y = -radius; y <= radius; ++y) {
      const std::uint8_t* const row = center + y * stride;
      const int h = half[static_cast<std::size_t>(y < 0 ? -y : y)];
      int sum = 0;
      for (int x = -h; x <= h; ++x) {
        sum += row[x];
        m10 += x * row[x];
      }
      m01 += y * sum;
    }
    return {static_cast<float>(m10), static_cast<float>(m01)};
  }

  /// (5), times 256. Weights of the Gaussian are in units of 1/256.
  static void smooth(const std::uint8_t* center, std::ptrdiff_t stride, Smoothed& out) {
    constexpr std::uint32_t w0 = 54, w1 = 49, w2 = 34, w3 = 18;
    static_assert(w0 + 2 * (w1 + w2 + w3) == 256);
    std::array<std::uint16_t, static_cast<std::size_t>(rows * width)> across{};
    for (int y = 0; y < rows; ++y) {
      const std::uint8_t* const in = center + (y - rows / 2) * stride - radius;
      std::uint16_t* const row = across.data() + y * width;
      for (int x = 0; x < side; ++x) {
        row[x] = static_cast<std::uint16_t>(w0 * in[x] + w1 * static_cast<unsigned>(in[x - 1] + in[x + 1]) +
                                            w2 * static_cast<unsigned>(in[x - 2] + in[x + 2]) +
                                            w3 * static_cast<unsigned>(in[x - 3] + in[x + 3]));
      }
    }
    for (int y = 0; y < side; ++y) {
      const std::uint16_t* const in = across.data() + (y + 3) * width;
      std::uint16_t* const row = out.data() + y * width;
      for (int x = 0; x < width; ++x) {
        const auto both = [&](int rows_away) -> std::uint32_t {
          return std::uint32_t{in[x - rows_away * width]} + in[x + rows_away * width];
        };
        row[x] = static_cast<std::uint16_t>((w0 * in[x] + w1 * both(1) + w2 * both(2) + w3 * both(3) + 128) >> 8);
      }
    }
  }

  /// (6) for theta with that cosine and sine.
  static BinaryDescriptor compare(const std::uint8_t* center, std::ptrdiff_t stride, float c, float s) {
    Smoothed J;
    smooth(center, stride, J);
    BinaryDescriptor out;
    constexpr float middle = radius + 0.5f;  // positive: the conversion to an integer rounds down
    const auto index = [&](float x, float y) {
      return static_cast<std::size_t>(static_cast<int>(s * x + c * y + middle) * width +
                                      static_cast<int>(c * x - s * y + middle));
    };
    for (std::size_t i = 0; i < OrbPattern::pairs; ++i) {
      const std::uint16_t p = J[index(orb_pattern.px[i], orb_pattern.py[i])];
      const std::uint16_t q = J[index(orb_pattern.qx[i], orb_pattern.qy[i])];
      out.words[i / 64] |= static_cast<std::uint64_t>(p < q) << (i % 64);
    }
    return out;
  }
};

}  // namespace plumbline
