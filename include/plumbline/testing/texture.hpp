#pragma once
/// Procedural textures of the simulated rooms: the reflectance in [0, 1] of a material at (u, v) [m] on its rectangle.
/// Pure functions of the position and a seed, without tables or state. Hard edges are band-limited when the texture is
/// baked into a mip chain (testing/mipmap.hpp).

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace plumbline::testing {

enum class Pattern : std::uint8_t {
  plain,    ///< uniform but for faint stains
  plaster,  ///< multi-octave noise
  brick,    ///< running bond with mortar
  wood,     ///< grain along u
  parquet,  ///< planks along u
  carpet,   ///< pile with a woven figure
  tiles,    ///< ceiling tiles with joints and pinholes
  poster,   ///< shapes, a title and lines of text
  label,    ///< a parcel: cardboard with a printed label
  books,    ///< spines of different widths, heights and tones
  sky       ///< what is seen through the window
};

struct Material {
  Pattern pattern = Pattern::plain;
  float base = 0.6f;       ///< mean reflectance
  float contrast = 0.02f;  ///< amplitude of the pattern
  std::uint32_t seed = 1;
};

constexpr std::uint32_t hash(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  std::uint32_t h = a * 0x9E3779B1u ^ b * 0x85EBCA77u ^ c * 0xC2B2AE3Du;
  h = (h ^ (h >> 15)) * 0x2C1B3C6Du;
  h = (h ^ (h >> 12)) * 0x297A2D39u;
  return h ^ (h >> 15);
}
/// Uniform in [0, 1).
constexpr float hash01(int a, int b, std::uint32_t seed) {
  return static_cast<float>(hash(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), seed) >> 8) * 0x1p-24f;
}

/// Value noise in [-1, 1] on the unit lattice, twice differentiable.
inline float value_noise(float x, float y, std::uint32_t seed) {
  const float fx = std::floor(x), fy = std::floor(y);
  const int ix = static_cast<int>(fx), iy = static_cast<int>(fy);
  const auto fade = [](float t) { return t * t * t * (t * (t * 6 - 15) + 10); };
  const float a = fade(x - fx), b = fade(y - fy);
  const float top = hash01(ix, iy, seed) * (1 - a) + hash01(ix + 1, iy, seed) * a;
  const float bottom = hash01(ix, iy + 1, seed) * (1 - a) + hash01(ix + 1, iy + 1, seed) * a;
  return 2 * (top * (1 - b) + bottom * b) - 1;
}

/// Octaves of value noise, each twice as fine; `persistence` is the amplitude ratio of one octave to the one before.
inline float octave_noise(float x, float y, int octaves, float persistence, std::uint32_t seed) {
  float sum = 0, amplitude = 1, total = 0;
  for (int i = 0; i < octaves; ++i, x *= 2, y *= 2, amplitude *= persistence) {
    sum += amplitude * value_noise(x, y, seed + static_cast<std::uint32_t>(i) * 101u);
    total += amplitude;
  }
  return sum / total;
}

namespace detail {

inline float brick(const Material& m, float u, float v) {
  constexpr float length = 0.22f, height = 0.075f, joint = 0.011f;  // [m]
  const int row = static_cast<int>(std::floor(v / height));
  const float shifted = u + (row % 2 == 0 ? 0 : length / 2);
  const int column = static_cast<int>(std::floor(shifted / length));
  const bool mortar =
      v - static_cast<float>(row) * height < joint || shifted - static_cast<float>(column) * length < joint;
  const float grain = 0.35f * octave_noise(u * 30, v * 30, 3, 0.7f, m.seed);
  return m.base + m.contrast * (mortar ? 1.2f + grain : hash01(row, column, m.seed) - 0.7f + grain);
}

inline float wood(const Material& m, float u, float v) {
  const float warp = value_noise(u * 2, v * 3, m.seed);
  return m.base + m.contrast * octave_noise(u * 2.5f, v * 28 + 1.5f * warp, 3, 0.8f, m.seed + 7);
}

inline float parquet(const Material& m, float u, float v) {
  constexpr float length = 0.9f, width = 0.14f, joint = 0.006f;  // [m]
  const int row = static_cast<int>(std::floor(v / width));
  const float shifted = u + length * hash01(row, 5, m.seed);
  const int column = static_cast<int>(std::floor(shifted / length));
  if (v - static_cast<float>(row) * width < joint || shifted - static_cast<float>(column) * length < joint) {
    return m.base - 1.3f * m.contrast;
  }
  const Material plank{Pattern::wood, m.base + m.contrast * (hash01(row, column, m.seed) - 0.5f), 0.6f * m.contrast,
                       hash(static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(column), m.seed)};
  return wood(plank, u, v);
}

inline float carpet(const Material& m, float u, float v) {
  constexpr float cell = 0.24f;  // [m]
  const float cu = std::floor(u / cell), cv = std::floor(v / cell);
  const float x = std::abs(u / cell - cu - 0.5f), y = std::abs(v / cell - cv - 0.5f);
  const float tone = hash01(static_cast<int>(cu), static_cast<int>(cv), m.seed) - 0.5f;
  const float figure = x + y < 0.2f ? tone : (x + y < 0.4f ? -tone : 0.4f * tone);
  return m.base + m.contrast * (figure + 0.6f * octave_noise(u * 25, v * 25, 3, 0.8f, m.seed));
}

inline float tiles(const Material& m, float u, float v) {
  constexpr float cell = 0.6f, joint = 0.012f;  // [m]
  const float x = u - cell * std::floor(u / cell), y = v - cell * std::floor(v / cell);
  if (x < joint || y < joint) return m.base - 2 * m.contrast;
  const float pit = value_noise(u * 35, v * 35, m.seed);
  return m.base + m.contrast * (0.4f * octave_noise(u * 3, v * 3, 2, 0.5f, m.seed) - (pit > 0.6f ? 1.2f : 0.0f));
}

/// Lines of random 4x6 glyphs with a pitch of `size` [m]: 1 where there is ink.
inline float text(float u, float v, float size, std::uint32_t seed) {
  const int column = static_cast<int>(std::floor(u / size)), line = static_cast<int>(std::floor(v / (1.6f * size)));
  const int x = static_cast<int>(5 * (u / size - static_cast<float>(column)));
  const int y = static_cast<int>(9.6f * (v / (1.6f * size) - static_cast<float>(line)));
  if (x > 3 || y > 5 || hash01(column, line, seed) < 0.15f) return 0;  // between letters, lines and words
  const std::uint32_t glyph = hash(static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(line), seed + 3);
  return static_cast<float>((glyph >> (x + 4 * y)) & 1u);
}

inline float poster(const Material& m, float u, float v, float width, float height) {
  const float x = u / width, y = v / height, margin = 0.03f;
  const float paper = 0.9f, ink = 0.12f;
  if (x < margin || y < margin || x > 1 - margin || y > 1 - margin) return paper;
  if (y < 0.22f) return x > 0.1f && x < 0.9f && text(u, v, 0.02f, m.seed) > 0 ? ink : paper;
  if (y < 0.34f) return text(u, v - 0.22f * height, 0.075f * height, m.seed + 1) > 0 ? ink : paper;
  float tone = m.base + 0.2f * octave_noise(x * 4, y * 4, 4, 0.6f, m.seed);
  for (int i = 0; i < 9; ++i) {  // shapes, later ones in front
    const auto draw = [&](int k) { return hash01(i, k, m.seed); };
    const float dx = x - draw(1), dy = y - (0.34f + 0.66f * draw(2)), radius = 0.05f + 0.16f * draw(3);
    const float c = std::cos(3 * draw(4)), s = std::sin(3 * draw(4)), du = c * dx + s * dy, dv = c * dy - s * dx;
    const bool inside = draw(5) < 0.4f   ? dx * dx + dy * dy < radius * radius
                        : draw(5) < 0.8f ? std::max(std::abs(du), 1.7f * std::abs(dv)) < radius
                                         : dv > 0 && std::abs(du) + dv < radius;
    if (inside) tone = 0.1f + 0.8f * draw(6) + 0.06f * octave_noise(x * 20, y * 20, 2, 0.7f, m.seed + 9);
  }
  return tone;
}

inline float label(const Material& m, float u, float v, float width, float height) {
  const float x = u / width, y = v / height;
  if (std::abs(y - 0.82f) < 0.04f) return m.base + 0.18f;  // adhesive tape
  if (x > 0.15f && x < 0.6f && y > 0.2f && y < 0.6f) return text(u, v, 0.05f * width, m.seed) > 0 ? 0.1f : 0.85f;
  return m.base + m.contrast * octave_noise(u * 12, v * 40, 3, 0.7f, m.seed);
}

inline float books(const Material& m, float u, float v, float height) {
  constexpr float pitch = 0.042f;  // [m]
  const auto left = [&](int i) { return pitch * (static_cast<float>(i) + 0.6f * hash01(i, 0, m.seed)); };
  int book = static_cast<int>(std::floor(u / pitch));
  if (u < left(book)) --book;
  const float top = height * (0.72f + 0.27f * hash01(book, 1, m.seed));
  if (v > top || u - left(book) < 0.003f) return 0.06f;
  const float tone = 0.1f + 0.75f * hash01(book, 2, m.seed), center = top * (0.3f + 0.5f * hash01(book, 3, m.seed));
  const float across = (u - left(book)) / (left(book + 1) - left(book));
  const bool title = std::abs(v - center) < 0.2f * top && std::abs(across - 0.5f) < 0.25f;
  if (title && text(v, u, 0.016f, m.seed + 5) > 0) return tone > 0.45f ? 0.08f : 0.9f;
  const bool band = std::abs(v - 0.12f * top) < 0.012f;
  return band ? 1 - tone : tone + 0.05f * value_noise(u * 60, v * 25, m.seed);
}

}  // namespace detail

/// Reflectance in [0, 1] at (u, v) [m] of a rectangle of width x height [m]; v points up on walls.
inline float reflectance(const Material& m, float u, float v, float width, float height) {
  switch (m.pattern) {
    case Pattern::plain: return m.base + m.contrast * octave_noise(u * 1.5f, v * 1.5f, 2, 0.5f, m.seed);
    case Pattern::plaster: return m.base + m.contrast * octave_noise(u * 3, v * 3, 6, 0.85f, m.seed);
    case Pattern::brick: return detail::brick(m, u, v);
    case Pattern::wood: return detail::wood(m, u, v);
    case Pattern::parquet: return detail::parquet(m, u, v);
    case Pattern::carpet: return detail::carpet(m, u, v);
    case Pattern::tiles: return detail::tiles(m, u, v);
    case Pattern::poster: return detail::poster(m, u, v, width, height);
    case Pattern::label: return detail::label(m, u, v, width, height);
    case Pattern::books: return detail::books(m, u, v, height);
    case Pattern::sky: {
      const float tree = octave_noise(u * 4, v * 4, 4, 0.6f, m.seed) - 2 * (v / height - 0.4f);
      return m.base - m.contrast * std::clamp(4 * tree, 0.0f, 1.0f) *
                          (0.7f + 0.5f * octave_noise(u * 9, v * 9, 3, 0.7f, m.seed + 11));
    }
  }
  return m.base;
}

}  // namespace plumbline::testing
