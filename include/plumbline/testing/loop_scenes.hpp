#pragma once
/// Scenes for loop closure: a ring corridor whose places all differ, and two scenes whose texture repeats exactly.
///
/// A period of the repeating scenes has rectangles of its own with the same materials and shapes, so that their
/// textures are equal. The light differs within 1 m of the corners and from side to side (testing/lighting.hpp).

#include <array>
#include <cstdint>
#include <numbers>

#include "plumbline/testing/furniture.hpp"
#include "plumbline/testing/ring_path.hpp"
#include "plumbline/testing/scene.hpp"

namespace plumbline::testing {

/// A corridor around a block, both made of square cells; the center line is that of RingPath.
struct RingCorridor {
  static constexpr double cell = 2.5, height = 2.6;  ///< [m] width of the corridor and distance of its doors
  static constexpr double hx = (RingPath::length + cell) / 2, hy = (RingPath::width + cell) / 2;  ///< outer walls
  static constexpr double bx = hx - cell, by = hy - cell;                                         ///< block

  struct Wall {
    SE3<double> at;
    int cells;
    double half() const { return cells * cell / 2; }
    /// The middle of that cell.
    SE3<double> middle(int i) const { return at * placement((i + 0.5) * cell - half(), 0, 0, 0); }
  };
  /// Four outer walls, then the four of the block.
  static std::array<Wall, 8> walls() {
    constexpr double pi = std::numbers::pi;
    const auto cells = [](double half) { return static_cast<int>(2 * half / cell + 0.5); };
    return {{{placement(hx, 0, 0, pi / 2), cells(hy)},
             {placement(0, hy, 0, pi), cells(hx)},
             {placement(-hx, 0, 0, -pi / 2), cells(hy)},
             {placement(0, -hy, 0, 0), cells(hx)},
             {placement(bx, 0, 0, -pi / 2), cells(by)},
             {placement(0, by, 0, 0), cells(bx)},
             {placement(-bx, 0, 0, pi / 2), cells(by)},
             {placement(0, -by, 0, pi), cells(bx)}}};
  }
};

/// The facade of `tiles` and what is opposite of it, along x.
struct Facade {
  static constexpr double period = 1.5, height = 3.5, front = 2.5, back = -2;  ///< [m]; front and back: y
  static constexpr int periods = 27;
  static constexpr double half = periods * period / 2;
};

namespace detail {

/// Floor and ceiling of a rectangle of w x h around the placement.
inline void add_floor_cell(Scene& scene, const SE3<double>& at, double w, double h, double height,
                           const Material& floor, const Material& ceiling) {
  scene.add_rectangle(at, {0, 0, 0}, Vec<double, 3>::UnitZ(), w, h, floor, 0.005);
  scene.add_rectangle(at, {0, 0, height}, -Vec<double, 3>::UnitZ(), w, h, ceiling, 0.006);
}

/// Furniture and pictures of one cell of the ring, of eight kinds; sizes and places vary with n and the seed.
inline void furnish_cell(Furnisher& add, const SE3<double>& at, int n, std::uint32_t seed) {
  const auto draw = [&](int k) { return static_cast<double>(hash01(n, k, seed)); };
  const double x = 0.5 * draw(0) - 0.25;
  switch ((3 * n + n / 8) % 8) {
    case 0: add.door(at, x); break;
    case 1:
      add.cabinet(at, x, 0.8 + 0.5 * draw(1), 0.7 + 0.4 * draw(2), static_cast<float>(0.25 + 0.5 * draw(3)));
      add.picture(at, x, 1.35, 0.5 + 0.5 * draw(4), 0.5 + 0.3 * draw(5));
      break;
    case 2: add.shelf(at * placement(x, 0, 0, 0), 2 + (n % 2), 4, 0.42, 0.34 + 0.1 * draw(1)); break;
    case 3:
      for (int k = 0; k < 4; ++k)
        add.poster(at, x + 0.5 * (k - 1.5), 0.75 + 0.8 * draw(k + 1), 0.35 + 0.1 * draw(k + 5),
                   0.5 + 0.2 * draw(k + 9));
      break;
    case 4:
      add.window(at, x, 0.9 + 0.7 * draw(1));
      add.radiator(at, x, 5 + n % 5);
      break;
    case 5: add.picture(at, x, 0.9 + 0.3 * draw(1), 1.0 + 0.6 * draw(2), 0.8 + 0.3 * draw(3)); break;
    case 6:
      add.table(at, x, 1.0 + 0.4 * draw(1), 0.45);
      add.parcel(at, {x - 0.3, 0.1, 0.74}, 0.2 * draw(2), {0.2 + 0.2 * draw(3), 0.2, 0.15 + 0.15 * draw(4)});
      add.poster(at, x, 1.3, 0.5 + 0.2 * draw(5), 0.6 + 0.2 * draw(6));
      break;
    default:
      for (int k = 0; k < 3; ++k)
        add.parcel(at, {x + 0.5 * (k - 1.4), 0.06, 0}, 0.15 * draw(k), {0.4, 0.3, 0.25 + 0.4 * draw(k + 1)});
      add.picture(at, x, 1.1, 0.6 + 0.4 * draw(5), 0.6);
  }
  for (const double side : {-1.0, 1.0}) {  // a notice at each end of the cell
    const int k = side < 0 ? 20 : 24;
    add.poster(at, side * 1.08, 0.6 + 1.3 * draw(k), 0.21 + 0.08 * draw(k + 1), 0.3 + 0.12 * draw(k + 2));
  }
}

inline Scene make_ring(std::uint32_t seed) {
  using Ring = RingCorridor;
  Scene scene;
  Furnisher add(scene, seed, true);
  for (const double side : {-1.0, 1.0}) {
    const auto cell = [&](const SE3<double>& at, double w, double h) {
      add_floor_cell(scene, at, w, h, Ring::height, add.material(Pattern::carpet, 0.36f, 0.22f),
                     add.material(Pattern::tiles, 0.75f, 0.12f));
    };
    cell(placement(0, side * RingPath::width / 2, 0, 0), 2 * Ring::hx, Ring::cell);
    cell(placement(side * RingPath::length / 2, 0, 0, 0), Ring::cell, 2 * Ring::by);
  }
  int n = 0, w = 0;
  for (const Ring::Wall& wall : Ring::walls()) {
    const bool bricks = ++w % 3 == 0;
    scene.add_front(wall.at, -wall.half(), wall.half(), 0, Ring::height, 0,
                    bricks ? add.material(Pattern::brick, 0.46f, 0.17f)
                           : add.material(Pattern::plaster, 0.5f + 0.02f * static_cast<float>(w), 0.32f));
    add.baseboard(wall.at, -wall.half(), wall.half());
    for (int i = 0; i < wall.cells; ++i) furnish_cell(add, wall.middle(i), n++, seed);
  }
  return scene;
}

/// The ring with a door and a sign in each cell of its walls; all cells are equal.
inline Scene make_doors(std::uint32_t seed) {
  using Ring = RingCorridor;
  Scene scene;
  const auto floor_cell = [&](double x, double y) {
    Furnisher add(scene, seed, true);  // from the begin: the same seeds in every cell
    add_floor_cell(scene, placement(x, y, 0, 0), Ring::cell, Ring::cell, Ring::height,
                   add.material(Pattern::carpet, 0.36f, 0.22f), add.material(Pattern::tiles, 0.75f, 0.12f));
  };
  for (double x = -RingPath::length / 2; x < RingPath::length / 2 + 0.1; x += Ring::cell) {
    for (const double side : {-1.0, 1.0}) floor_cell(x, side * RingPath::width / 2);
  }
  for (double y = Ring::cell / 2 - Ring::by; y < Ring::by; y += Ring::cell) {
    for (const double side : {-1.0, 1.0}) floor_cell(side * RingPath::length / 2, y);
  }
  for (const Ring::Wall& wall : Ring::walls()) {
    for (int i = 0; i < wall.cells; ++i) {
      const SE3<double> at = wall.middle(i);
      Furnisher add(scene, seed, true);
      scene.add_front(at, -Ring::cell / 2, Ring::cell / 2, 0, Ring::height, 0,
                      add.material(Pattern::plaster, 0.55f, 0.32f));
      add.baseboard(at, -Ring::cell / 2, Ring::cell / 2);
      add.door(at, 0);
      add.poster(at, 0.85, 1.3, 0.3, 0.42);
    }
  }
  return scene;
}

/// A facade of bricks with a window and a sign in each period, under a roof; bricks alone opposite of it.
inline Scene make_tiles(std::uint32_t seed) {
  using F = Facade;
  constexpr double pi = std::numbers::pi, h = F::period / 2, middle = (F::front + F::back) / 2;
  Scene scene;
  for (int i = 0; i < F::periods; ++i) {
    const double x = (i + 0.5) * F::period - F::half;
    const SE3<double> front = placement(x, F::front, 0, pi), back = placement(x, F::back, 0, 0);
    Furnisher add(scene, seed, true);
    add_floor_cell(scene, placement(x, middle, 0, 0), F::period, F::front - F::back, F::height,
                   add.material(Pattern::carpet, 0.4f, 0.2f), add.material(Pattern::plaster, 0.7f, 0.2f));
    scene.add_front(front, -h, h, 0, F::height, 0, add.material(Pattern::brick, 0.46f, 0.17f));
    scene.add_front(back, -h, h, 0, F::height, 0, add.material(Pattern::brick, 0.5f, 0.15f));
    add.window(front, -0.15, 0.8);
    add.poster(front, 0.53, 1.2, 0.28, 0.4);
  }
  Furnisher add(scene, seed + 1, true);
  for (const double side : {-1.0, 1.0}) {
    const double w = (F::front - F::back) / 2;
    scene.add_front(placement(side * F::half, middle, 0, side * pi / 2), -w, w, 0, F::height, 0,
                    add.material(Pattern::plaster, 0.55f, 0.3f));
  }
  return scene;
}

}  // namespace detail
}  // namespace plumbline::testing
