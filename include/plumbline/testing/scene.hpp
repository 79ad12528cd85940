#pragma once
/// A scene of textured rectangles: boxes and panels placed along walls.
///
/// A rectangle is p(u, v) = origin + u e_u + v e_v, 0 <= u <= width, 0 <= v <= height, seen from the side of its normal
/// n = e_u x e_v only. World: z up. A placement has x along a wall, y out of the wall, z up.

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/testing/texture.hpp"

namespace plumbline::testing {

struct Rectangle {
  Vec<double, 3> origin, e_u, e_v;  ///< world; unit axes
  double width, height;             ///< [m]
  Material material;
  double texel = 0.004;  ///< [m]

  Vec<double, 3> normal() const { return e_u.cross(e_v); }

  /// Distance along the unit ray to the front of the rectangle; infinite when it is missed.
  double intersect(const Vec<double, 3>& from, const Vec<double, 3>& ray) const {
    const Vec<double, 3> n = normal();
    const double facing = -n.dot(ray), height_above = n.dot(from - origin);
    if (!(facing > 0 && height_above > 0)) return std::numeric_limits<double>::infinity();
    const double t = height_above / facing;
    const Vec<double, 3> d = from + t * ray - origin;
    const double u = d.dot(e_u), v = d.dot(e_v);
    return u >= 0 && u <= width && v >= 0 && v <= height ? t : std::numeric_limits<double>::infinity();
  }

  /// Euclidean distance of a point to the rectangle.
  double distance(const Vec<double, 3>& p) const {
    const Vec<double, 3> d = p - origin;
    const double u = std::clamp(d.dot(e_u), 0.0, width), v = std::clamp(d.dot(e_v), 0.0, height);
    return (d - u * e_u - v * e_v).norm();
  }
};

/// The placement at (x, y, z) turned about the vertical by yaw.
inline SE3<double> placement(double x, double y, double z, double yaw) {
  return {SO3<double>::exp({0, 0, yaw}), Vec<double, 3>(x, y, z)};
}

class Scene {
 public:
  std::vector<Rectangle> rectangles;

  /// A rectangle with center and normal in the placement; e_v is up (e_u the placement's x where it lies flat).
  void add_rectangle(const SE3<double>& at, const Vec<double, 3>& center, const Vec<double, 3>& normal, double width,
                     double height, const Material& material, double texel = 0.004) {
    const bool flat = std::abs(normal.z()) > 0.5;
    const Vec<double, 3> e_u = flat ? Vec<double, 3>::UnitX() : Vec<double, 3>(Vec<double, 3>::UnitZ().cross(normal));
    const Vec<double, 3> e_v = normal.cross(e_u);
    const Vec<double, 3> origin = center - 0.5 * width * e_u - 0.5 * height * e_v;
    rectangles.push_back({at * origin, at.rotation() * e_u, at.rotation() * e_v, width, height, material, texel});
  }

  /// A panel facing the placement's +y at depth y: x in [x0, x1], z in [z0, z1].
  void add_front(const SE3<double>& at, double x0, double x1, double z0, double z1, double y, const Material& material,
                 double texel = 0.004) {
    add_rectangle(at, {(x0 + x1) / 2, y, (z0 + z1) / 2}, Vec<double, 3>::UnitY(), x1 - x0, z1 - z0, material, texel);
  }

  /// The box [lo, hi] of the placement; the face toward +y has a material of its own. Faces that lie on the wall
  /// (y = 0) or on the floor (z = 0) of the placement cannot be seen and are left out.
  void add_box(const SE3<double>& at, const Vec<double, 3>& lo, const Vec<double, 3>& hi, const Material& sides,
               const Material& front, double front_texel = 0.004) {
    const Vec<double, 3> c = (lo + hi) / 2, size = hi - lo, h = size / 2;
    using V = Vec<double, 3>;
    add_rectangle(at, c + h.x() * V::UnitX(), V::UnitX(), size.y(), size.z(), sides);
    add_rectangle(at, c - h.x() * V::UnitX(), -V::UnitX(), size.y(), size.z(), sides);
    add_rectangle(at, c + h.y() * V::UnitY(), V::UnitY(), size.x(), size.z(), front, front_texel);
    if (lo.y() > 1e-9) add_rectangle(at, c - h.y() * V::UnitY(), -V::UnitY(), size.x(), size.z(), sides);
    add_rectangle(at, c + h.z() * V::UnitZ(), V::UnitZ(), size.x(), size.y(), sides);
    if (lo.z() > 1e-9) add_rectangle(at, c - h.z() * V::UnitZ(), -V::UnitZ(), size.x(), size.y(), sides);
  }
  void add_box(const SE3<double>& at, const Vec<double, 3>& lo, const Vec<double, 3>& hi, const Material& material) {
    add_box(at, lo, hi, material, material);
  }

  /// Distance along the unit ray to the first surface [m]; infinite when there is none.
  double intersect(const Vec<double, 3>& from, const Vec<double, 3>& ray) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Rectangle& r : rectangles) nearest = std::min(nearest, r.intersect(from, ray));
    return nearest;
  }
  /// Distance of a point to the nearest surface [m].
  double distance(const Vec<double, 3>& p) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Rectangle& r : rectangles) nearest = std::min(nearest, r.distance(p));
    return nearest;
  }
};

}  // namespace plumbline::testing
