#pragma once
/// The simulated scenes by name. The world's origin is on the floor in the middle; the cameras' paths
/// (testing/trajectory.hpp) keep to the free space around it.

#include <array>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string_view>

#include "plumbline/testing/furniture.hpp"
#include "plumbline/testing/loop_scenes.hpp"
#include "plumbline/testing/scene.hpp"

namespace plumbline::testing {

inline constexpr std::array<std::string_view, 9> scene_names = {"room", "room_lowtex", "boards", "corridor", "walk",
                                                                "hall", "ring",        "doors",  "tiles"};

namespace detail {

inline constexpr double pi = std::numbers::pi;

/// Floor and ceiling of a space of 2 hx by 2 hy, z in [0, height].
inline void add_floor_and_ceiling(Scene& scene, double hx, double hy, double height, const Material& floor,
                                  const Material& ceiling) {
  const SE3<double> at;
  scene.add_rectangle(at, {0, 0, 0}, Vec<double, 3>::UnitZ(), 2 * hx, 2 * hy, floor, 0.005);
  scene.add_rectangle(at, {0, 0, height}, -Vec<double, 3>::UnitZ(), 2 * hx, 2 * hy, ceiling, 0.006);
}

inline Scene make_room(std::uint32_t seed, bool textured) {
  constexpr double hx = 3.2, hy = 2.7, height = 2.7;
  Scene scene;
  Furnisher add(scene, seed, textured);
  add_floor_and_ceiling(scene, hx, hy, height, add.material(Pattern::parquet, 0.38f, 0.2f),
                        add.material(Pattern::tiles, 0.75f, 0.12f));
  const SE3<double> north = placement(0, hy, 0, pi), south = placement(0, -hy, 0, 0);
  const SE3<double> east = placement(hx, 0, 0, pi / 2), west = placement(-hx, 0, 0, -pi / 2);
  scene.add_front(north, -hx, hx, 0, height, 0, add.material(Pattern::plaster, 0.62f, 0.34f));
  scene.add_front(south, -hx, hx, 0, height, 0, add.material(Pattern::brick, 0.45f, 0.16f));
  scene.add_front(east, -hy, hy, 0, height, 0, add.material(Pattern::plaster, 0.62f, 0.34f));
  scene.add_front(west, -hy, hy, 0, height, 0, add.material(Pattern::plaster, 0.54f, 0.32f));
  add.baseboard(north, -hx, hx), add.baseboard(south, -hx, hx), add.baseboard(east, -hy, hy),
      add.baseboard(west, -hy, hy);

  add.shelf(north * placement(1.6, 0, 0, 0), textured ? 4 : 2, textured ? 5 : 3, textured ? 0.42 : 0.6,
            textured ? 0.36 : 0.55);
  add.door(north, -2.2);
  add.cabinet(north, -0.6, 0.9, 1.15, 0.66f);
  add.picture(north, 0.25, 1.3, 0.5, 0.7);
  add.table(south, -0.9, 1.6, 0.7);
  add.monitor(south, -0.9, 0.25);
  add.picture(south, 1.4, 1.25, 1.0, 0.7);
  add.cabinet(south, 1.6, 1.1, 0.8, 0.3f);
  add.window(east, 0.1, 1.7);
  add.radiator(east, 0.1, textured ? 9 : 3);
  add.cabinet(east, -1.9, 0.8, 1.9, 0.74f);
  add.door(west, 1.5);
  add.table(west, -0.9, 1.3, 0.6);
  add.picture(west, -1.0, 1.25, 0.9, 0.65);
  add.parcel(south, {0.35, 0.15, 0}, 0.3, {0.4, 0.3, 0.35});
  add.parcel(east, {1.6, 0.1, 0}, -0.2, {0.5, 0.35, 0.4});
  if (!textured) return scene;
  add.parcel(east, {1.65, 0.12, 0.4}, 0.1, {0.35, 0.28, 0.25});
  add.parcel(west, {-1.3, 0.12, 0.74}, -0.25, {0.3, 0.22, 0.2});
  add.parcel(south, {-1.55, 0.2, 0.74}, 0.35, {0.22, 0.18, 0.16});
  add.parcel(north, {-0.95, 0.08, 1.15}, 0.12, {0.34, 0.26, 0.24});
  add.chair(south, -0.6, 0.75, pi + 0.4);
  add.chair(west, -0.7, 0.7, pi - 0.3);
  add.poster(north, -1.35, 1.2, 0.5, 0.75);
  add.poster(north, -0.5, 1.6, 0.45, 0.62);
  add.poster(south, -2.4, 1.1, 0.6, 0.85);
  add.poster(south, -0.15, 1.4, 0.5, 0.7);
  add.poster(south, 2.55, 1.2, 0.55, 0.75);
  add.poster(east, -1.15, 1.1, 0.42, 0.6);
  add.poster(east, 1.55, 1.2, 0.6, 0.85);
  add.poster(east, 2.25, 1.3, 0.4, 0.55);
  add.poster(west, 0.4, 1.25, 0.6, 0.85);
  add.poster(west, -2.1, 1.1, 0.6, 0.85);
  for (int k = 0; k < 7; ++k) {  // notes on the walls, in the gaps between the furniture
    const double jitter = 0.08 * hash01(k, 3, seed);
    if (k < 2) add.poster(north, -1.45 + 0.25 * k, 0.5 + jitter + 0.08 * k, 0.21, 0.297);
    if (k < 3) add.poster(north, -0.9 + 0.4 * k, 2.28 + jitter, 0.21, 0.297);
    if (k < 3) add.poster(east, -1.35 + 0.25 * k, 0.35 + 1.4 * (k % 2) + jitter, 0.21, 0.297);
    if (k < 5) add.poster(west, -0.1 + 0.24 * k, 0.6 + jitter + 0.1 * (k % 2), 0.21, 0.297);
    add.poster(west, -1.6 + 0.28 * k, 2.05 + jitter, 0.21, 0.297);
  }
  return scene;
}

/// The bare room hung with plain boards, turned each by up to 15 degrees, each with a field of another tone: many long
/// edges in many directions and a few corners, no texture.
inline Scene make_boards(std::uint32_t seed) {
  constexpr double hx = 3.2, hy = 2.7, height = 2.7, pitch = 0.75;
  Scene scene;
  Furnisher add(scene, seed, false);
  const auto plain = [&](float base) { return add.material(Pattern::plain, base, 0.02f); };
  add_floor_and_ceiling(scene, hx, hy, height, plain(0.35f), plain(0.75f));
  const std::array<SE3<double>, 4> walls = {placement(hx, 0, 0, pi / 2), placement(0, hy, 0, pi),
                                            placement(-hx, 0, 0, -pi / 2), placement(0, -hy, 0, 0)};
  const std::array<double, 4> half = {hy, hx, hy, hx};
  for (int i = 0; i < 4; ++i) {
    const double w = half[std::size_t(i)];
    scene.add_front(walls[std::size_t(i)], -w, w, 0, height, 0, plain(0.6f));
    const int columns = static_cast<int>(2 * w / pitch);
    for (int k = 0; k < 3 * columns; ++k) {
      const auto draw = [&](int j) { return static_cast<double>(hash01(100 * i + k, j, seed)); };
      const int column = k / 3;
      const double x = (column + 0.5) * pitch - 0.5 * columns * pitch, z = 0.5 + 0.85 * (k % 3);
      const SE3<double> at =
          walls[std::size_t(i)] * SE3<double>(SO3<double>::exp({0, 0.52 * (draw(0) - 0.5), 0}), {x, 0, z});
      const double a = 0.18 + 0.12 * draw(1), b = 0.22 + 0.13 * draw(2), thick = 0.02 + 0.13 * draw(3);
      const float tone = 0.1f + 0.4f * static_cast<float>(draw(4)), field = tone + 0.4f;
      scene.add_box(at, {-a, 0, -b}, {a, thick, b}, plain(draw(5) < 0.5 ? field : tone));
      scene.add_front(at, -0.6 * a, 0.6 * a, -0.6 * b, 0.6 * b, thick + 0.003, plain(draw(5) < 0.5 ? tone : field));
    }
  }
  return scene;
}

/// A corridor 1.8 m wide around a block of 2.8 m x 2.0 m.
inline Scene make_corridor(std::uint32_t seed) {
  constexpr double hx = 3.2, hy = 2.8, bx = 1.4, by = 1.0, height = 2.6;
  Scene scene;
  Furnisher add(scene, seed, true);
  add_floor_and_ceiling(scene, hx, hy, height, add.material(Pattern::carpet, 0.36f, 0.22f),
                        add.material(Pattern::tiles, 0.75f, 0.12f));
  const std::array<SE3<double>, 4> outer = {placement(hx, 0, 0, pi / 2), placement(0, hy, 0, pi),
                                            placement(-hx, 0, 0, -pi / 2), placement(0, -hy, 0, 0)};
  const std::array<SE3<double>, 4> block = {placement(bx, 0, 0, -pi / 2), placement(0, by, 0, 0),
                                            placement(-bx, 0, 0, pi / 2), placement(0, -by, 0, pi)};
  const std::array<double, 4> outer_half = {hy, hx, hy, hx}, block_half = {by, bx, by, bx};
  for (int i = 0; i < 4; ++i) {
    const SE3<double>&out = outer[std::size_t(i)], &in = block[std::size_t(i)];
    const double ow = outer_half[std::size_t(i)], iw = block_half[std::size_t(i)];
    scene.add_front(out, -ow, ow, 0, height, 0,
                    add.material(Pattern::plaster, 0.54f + 0.03f * static_cast<float>(i), 0.32f));
    scene.add_front(in, -iw, iw, 0, height, 0, add.material(Pattern::brick, 0.46f, 0.17f));
    add.baseboard(out, -ow, ow), add.baseboard(in, -iw, iw);
    add.door(out, -0.5 * ow);
    add.picture(out, 0.3, 1.2, 0.7, 0.5);
    for (int k = 0; k < 3; ++k) {
      const double jitter = 0.2 * hash01(i, k, seed);
      add.poster(out, -1.0 + 0.75 * k + (k > 1 ? 0.5 : 0) + jitter - 0.05, 0.95 + jitter + (k == 1 ? 0.75 : 0), 0.42,
                 0.6);
      add.poster(in, -0.75 + 0.65 * k + jitter, 1.05 + jitter, 0.4, 0.56);
      add.poster(out, ow - 0.3 - 0.45 * k, 1.0 + 0.3 * k - 2 * jitter, 0.3, 0.42);
      add.poster(out, 0.3 - ow + 0.3 * k, 1.75 - jitter, 0.21, 0.297);
      add.poster(out, -0.62 * ow + 0.33 * k, 0.62 + jitter, 0.21, 0.297);
    }
    add.parcel(out, {ow - 0.75, 0.08, 0}, 0.15, {0.4, 0.3, 0.3});
    add.parcel(in, {-iw + 0.3, 0.05, 0}, -0.1, {0.3, 0.22, 0.3});
  }
  return scene;
}

/// A sports hall of 2 hx by 2 hy: banners, windows, doors and boxes along its walls.
inline Scene make_hall(std::uint32_t seed, double hx = 15, double hy = 10, double height = 8) {
  Scene scene;
  Furnisher add(scene, seed, true);
  add_floor_and_ceiling(scene, hx, hy, height, add.material(Pattern::parquet, 0.42f, 0.5f),
                        add.material(Pattern::tiles, 0.7f, 0.6f));
  const std::array<SE3<double>, 4> walls = {placement(hx, 0, 0, pi / 2), placement(0, hy, 0, pi),
                                            placement(-hx, 0, 0, -pi / 2), placement(0, -hy, 0, 0)};
  const std::array<double, 4> half = {hy, hx, hy, hx};
  for (int i = 0; i < 4; ++i) {
    const SE3<double>& wall = walls[std::size_t(i)];
    const double w = half[std::size_t(i)];
    scene.add_front(wall, -w, w, 0, height, 0,
                    add.material(i % 2 == 0 ? Pattern::brick : Pattern::plaster, 0.55f, 0.4f));
    add.baseboard(wall, -w, w);
    add.door(wall, -0.55 * w);
    add.door(wall, 0.62 * w);
    const int columns = static_cast<int>(w) - 1;
    for (int k = 0; k < columns; ++k) {
      const double at = -w + 1.2 + 2 * k + 0.5 * hash01(i, k, seed);
      add.poster(wall, at, 2.4 + 1.2 * hash01(k, i + 7, seed), 1.1, 1.5);
      add.poster(wall, at + 0.9, 4.6 + 1.6 * hash01(k, i + 11, seed), 1.4, 1.0);
      if (k % 2 == 0) add.picture(wall, at + 0.7, 1.1, 0.9, 0.7);
      if (k % 3 == 1) add.parcel(wall, {at, 0.5, 0}, 0.4 * hash01(k, i, seed), {0.9, 0.7, 0.8});
    }
  }
  return scene;
}

inline std::uint32_t surface_seed_of(std::uint64_t seed) {
  return hash(static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32), 1);
}

}  // namespace detail

/// The hall in another size: 2 hx by 2 hy by height [m].
inline Scene make_hall(double hx, double hy, double height, std::uint64_t seed) {
  return detail::make_hall(detail::surface_seed_of(seed), hx, hy, height);
}

/// The scene of that name, its surfaces varied by the seed; nothing when the name is unknown.
inline std::optional<Scene> make_scene(std::string_view name, std::uint64_t seed = 1) {
  const std::uint32_t surface_seed = detail::surface_seed_of(seed);
  if (name == "room") return detail::make_room(surface_seed, true);
  if (name == "room_lowtex") return detail::make_room(surface_seed, false);
  if (name == "boards") return detail::make_boards(surface_seed);
  if (name == "corridor" || name == "walk") return detail::make_corridor(surface_seed);
  if (name == "hall") return detail::make_hall(surface_seed);
  if (name == "ring") return detail::make_ring(surface_seed);
  if (name == "doors") return detail::make_doors(surface_seed);
  if (name == "tiles") return detail::make_tiles(surface_seed);
  return std::nullopt;
}

}  // namespace plumbline::testing
