#pragma once
/// Furniture of the simulated rooms, each piece standing at a placement with its back to the wall (y = 0).

#include <cstdint>

#include "plumbline/testing/scene.hpp"

namespace plumbline::testing {

/// Adds pieces to a scene; `detail` false keeps the shapes and drops the surface textures.
class Furnisher {
 public:
  using V = Vec<double, 3>;

  Furnisher(Scene& scene, std::uint32_t seed, bool detail) : scene_(scene), seed_(seed), detail_(detail) {}

  /// The material with a seed of its own; plain when surfaces have no texture.
  Material material(Pattern pattern, float base, float contrast) {
    const std::uint32_t seed = hash(seed_, ++count_, 17);
    return detail_ ? Material{pattern, base, contrast, seed} : Material{Pattern::plain, base, 0.02f, seed};
  }

  void poster(const SE3<double>& at, double x, double z, double width, double height) {
    const Material sheet = material(Pattern::poster, 0.5f, 0.3f);
    const double y = 0.018 + 0.0005 * (count_ % 16);  // overlapping sheets lie on each other
    scene_.add_front(at, x - width / 2, x + width / 2, z, z + height, y, sheet, 0.003);
  }

  void picture(const SE3<double>& at, double x, double z, double width, double height) {
    const double x0 = x - width / 2, x1 = x + width / 2, z1 = z + height;
    frame(at, x0, x1, z, z1, 0.05, 0.03, material(Pattern::wood, 0.18f, 0.06f));
    scene_.add_front(at, x0 + 0.05, x1 - 0.05, z + 0.05, z1 - 0.05, 0.008, material(Pattern::poster, 0.55f, 0.3f),
                     0.003);
  }

  void door(const SE3<double>& at, double x) {
    const Material wood = material(Pattern::wood, 0.42f, 0.1f), trim = material(Pattern::plain, 0.8f, 0.02f);
    const Material metal = material(Pattern::plain, 0.75f, 0.02f), inset = material(Pattern::wood, 0.34f, 0.1f);
    scene_.add_box(at, {x - 0.52, 0, 0}, {x - 0.44, 0.05, 2.1}, trim);
    scene_.add_box(at, {x + 0.44, 0, 0}, {x + 0.52, 0.05, 2.1}, trim);
    scene_.add_box(at, {x - 0.52, 0, 2.1}, {x + 0.52, 0.05, 2.18}, trim);
    scene_.add_front(at, x - 0.44, x + 0.44, 0, 2.1, 0.01, wood);
    scene_.add_front(at, x - 0.3, x + 0.3, 1.15, 1.95, 0.016, inset);
    scene_.add_front(at, x - 0.3, x + 0.3, 0.15, 0.95, 0.016, inset);
    scene_.add_box(at, {x - 0.4, 0.03, 1.02}, {x - 0.28, 0.06, 1.05}, metal);
  }

  void window(const SE3<double>& at, double x, double width) {
    const Material trim = material(Pattern::plain, 0.85f, 0.02f);
    const double x0 = x - width / 2, x1 = x + width / 2, z0 = 0.95, z1 = 2.2;
    scene_.add_front(at, x0, x1, z0, z1, 0.005, material(Pattern::sky, 0.95f, 0.55f));
    frame(at, x0, x1, z0, z1, 0.07, 0.06, trim);
    scene_.add_box(at, {x - 0.03, 0.008, z0 + 0.07}, {x + 0.03, 0.05, z1 - 0.07}, trim);
    scene_.add_box(at, {x0, 0.008, z0 + 0.8}, {x1, 0.045, z0 + 0.84}, trim);
    scene_.add_box(at, {x0 - 0.06, 0, z0 - 0.04}, {x1 + 0.06, 0.18, z0}, trim);
  }

  void radiator(const SE3<double>& at, double x, int fins) {
    const Material white = material(Pattern::plain, 0.72f, 0.02f);
    for (int i = 0; i < fins; ++i) {
      const double x0 = x + 0.09 * (i - 0.5 * fins);
      scene_.add_box(at, {x0, 0.06, 0.14}, {x0 + 0.06, 0.14, 0.74}, white);
    }
    scene_.add_box(at, {x - 0.045 * fins, 0.08, 0.2}, {x + 0.045 * fins, 0.12, 0.26}, white);
  }

  /// Compartments with books and parcels.
  void shelf(const SE3<double>& at, int columns, int rows, double cell_width, double cell_height) {
    const Material wood = material(Pattern::wood, 0.5f, 0.14f), back = material(Pattern::wood, 0.25f, 0.06f);
    constexpr double board = 0.025, depth = 0.32;
    const double width = columns * cell_width, height = rows * cell_height;
    for (int i = 0; i <= columns; ++i) {
      const double x = i * cell_width - width / 2;
      scene_.add_box(at, {x - board / 2, 0, 0}, {x + board / 2, depth, height + board}, wood);
    }
    for (int j = 0; j <= rows; ++j) {
      scene_.add_box(at, {-width / 2, 0, j * cell_height}, {width / 2, depth - 0.003, j * cell_height + board}, wood);
    }
    scene_.add_front(at, -width / 2, width / 2, 0, height, 0.004, back);
    for (int i = 0; i < columns; ++i) {
      for (int j = 0; j < rows; ++j) {
        const double fill = hash01(i, j, seed_ + 1), x0 = i * cell_width - width / 2 + board,
                     z0 = j * cell_height + board;
        const double content = cell_width - 2 * board;
        if (fill < 0.2) continue;  // an empty compartment
        if (fill < 0.4 || !detail_) {
          scene_.add_box(at, {x0 + 0.04, 0, z0}, {x0 + 0.8 * content, 0.25, z0 + 0.6 * cell_height},
                         material(Pattern::label, 0.5f, 0.08f));
        } else {
          const double length = (0.7 + 0.3 * hash01(i, j, seed_ + 2)) * content;
          const Material cover = material(Pattern::plain, 0.35f, 0.1f), spines = material(Pattern::books, 0.5f, 0.3f);
          scene_.add_box(at, {x0, 0, z0}, {x0 + length, 0.24, z0 + 0.8 * cell_height}, cover, spines, 0.003);
        }
      }
    }
  }

  void cabinet(const SE3<double>& at, double x, double width, double height, float tone) {
    const Material body = material(Pattern::wood, tone, 0.08f), handle = material(Pattern::plain, 0.15f, 0.02f);
    scene_.add_box(at, {x - width / 2, 0, 0}, {x + width / 2, 0.45, height}, body);
    for (const double side : {-1.0, 1.0}) {
      const double x0 = x + side * width / 4, w = width / 4 - 0.015;
      scene_.add_box(at, {x0 - w, 0.45, 0.08}, {x0 + w, 0.465, height - 0.02}, body);
      scene_.add_box(at, {x + side * 0.04 - 0.01, 0.465, height / 2 - 0.09},
                     {x + side * 0.04 + 0.01, 0.49, height / 2 + 0.09}, handle);
    }
  }

  void table(const SE3<double>& at, double x, double width, double depth) {
    const Material top = material(Pattern::wood, 0.62f, 0.12f), leg = material(Pattern::plain, 0.22f, 0.03f);
    scene_.add_box(at, {x - width / 2, 0.03, 0.7}, {x + width / 2, depth, 0.74}, top);
    for (const double lx : {x - width / 2 + 0.05, x + width / 2 - 0.1}) {
      for (const double ly : {0.06, depth - 0.11}) scene_.add_box(at, {lx, ly, 0}, {lx + 0.05, ly + 0.05, 0.7}, leg);
    }
  }

  void monitor(const SE3<double>& at, double x, double y) {
    const Material shell = material(Pattern::plain, 0.1f, 0.02f);
    scene_.add_box(at, {x - 0.12, y - 0.08, 0.74}, {x + 0.12, y + 0.1, 0.755}, shell);
    scene_.add_box(at, {x - 0.03, y - 0.03, 0.755}, {x + 0.03, y, 0.9}, shell);
    scene_.add_box(at, {x - 0.3, y, 0.84}, {x + 0.3, y + 0.04, 1.2}, shell);
    scene_.add_front(at, x - 0.28, x + 0.28, 0.86, 1.18, y + 0.043, material(Pattern::poster, 0.4f, 0.2f), 0.003);
  }

  /// A box with a label, its near lower left corner turned by yaw.
  void parcel(const SE3<double>& at, const V& corner, double yaw, const V& size) {
    const SE3<double> turned = at * placement(corner.x(), corner.y(), corner.z(), yaw);
    scene_.add_box(turned, {0, 0.001, 0}, size, material(Pattern::label, 0.55f, 0.1f),
                   material(Pattern::label, 0.5f, 0.1f), 0.003);
  }

  void chair(const SE3<double>& at, double x, double y, double yaw) {
    const SE3<double> turned = at * placement(x, y, 0, yaw);
    const Material cloth = material(Pattern::carpet, 0.3f, 0.2f), leg = material(Pattern::plain, 0.12f, 0.02f);
    scene_.add_box(turned, {-0.22, -0.22, 0.43}, {0.22, 0.22, 0.48}, cloth);
    scene_.add_box(turned, {-0.22, 0.19, 0.48}, {0.22, 0.23, 0.95}, cloth);
    for (const double lx : {-0.2, 0.16}) {
      for (const double ly : {-0.2, 0.16}) scene_.add_box(turned, {lx, ly, 0}, {lx + 0.04, ly + 0.04, 0.43}, leg);
    }
  }

  void baseboard(const SE3<double>& at, double x0, double x1) {
    scene_.add_box(at, {x0, 0, 0}, {x1, 0.015, 0.09}, material(Pattern::plain, 0.35f, 0.02f));
  }

 private:
  /// Four bars around [x0, x1] x [z0, z1].
  void frame(const SE3<double>& at, double x0, double x1, double z0, double z1, double bar, double depth,
             const Material& m) {
    scene_.add_box(at, {x0, 0, z0}, {x1, depth, z0 + bar}, m);
    scene_.add_box(at, {x0, 0, z1 - bar}, {x1, depth, z1}, m);
    scene_.add_box(at, {x0, 0, z0 + bar}, {x0 + bar, depth, z1 - bar}, m);
    scene_.add_box(at, {x1 - bar, 0, z0 + bar}, {x1, depth, z1 - bar}, m);
  }

  Scene& scene_;
  std::uint32_t seed_;
  std::uint32_t count_ = 0;
  bool detail_;
};

}  // namespace plumbline::testing
