#pragma once
/// Images and depth of a scene for any central camera, by ray casting in tiles.
///
/// In the camera frame a ray is t b with the unit bearing b of the pixel. A rectangle with origin o, axes e_u, e_v and
/// plane n . X = d is met where 1/t = w(b) = n . b / d at (u, v) = (A(b)/w, B(b)/w), A and B linear in the bearing:
///   A(b) = (e_u - (e_u . o)/d n) . b,   B(b) = (e_v - (e_v . o)/d n) . b                                     (1)
/// A ray hits when w > 0, 0 <= A <= width w and 0 <= B <= height w: five linear forms that are all positive.        (2)
/// Their extrema over the bearings of a tile reject most rectangles for the whole tile. One ray at the pixel's center
/// finds the surface; pixels with an edge in the 3x3 neighborhood are resolved by 16 rays against the surfaces found
/// there. No clipping and no division before shading, and no assumption on the camera but smooth bearings.
/// Under a shutter that rolls every two rows have a pose of their own.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/assert.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/testing/lighting.hpp"
#include "plumbline/testing/mipmap.hpp"
#include "plumbline/testing/scene.hpp"

namespace plumbline::testing {

class Renderer {
 public:
  /// Bakes the textures (about a second). `texel_factor` > 1 makes textures and light coarser: for tests of the
  /// geometry.
  template <CameraModel Camera>
  Renderer(const Scene& scene, const Camera& camera, int width, int height, double texel_factor = 1)
      : scene_(scene),
        width_(width),
        height_(height),
        stride_((width / tile + 1) * tile),
        rows_((height / tile + 1) * tile),
        bearings_(static_cast<std::size_t>(stride_ * rows_)),
        surface_(bearings_.size()),
        inverse_range_(bearings_.size()) {
    for (int y = 0; y < rows_; ++y) {
      for (int x = 0; x < stride_;
           ++x) {  // the bearings extend beyond the image, so that differences exist on its border
        using S = typename Camera::Scalar;
        const Unprojection<S> ray = camera.unproject(Vec<S, 2>(S(x), S(y)));
        bearings_.set(index(x, y),
                      ray.valid ? Vec<float, 3>(ray.bearing.template cast<float>()) : Vec<float, 3>::Zero());
      }
    }
    for (const Rectangle& r : scene_.rectangles) {
      const LightMap light(scene_, r, LightMap::fine * texel_factor);
      const float w = static_cast<float>(r.width), h = static_cast<float>(r.height);
      textures_.emplace_back(
          [&](float u, float v) { return 255 * light.at(u, v) * reflectance(r.material, u, v, w, h); }, w, h,
          static_cast<float>(r.texel * texel_factor));
    }
  }

  /// Intensity in 0..255 and depth z [m] (0: nothing there). Both images have the size of the camera.
  void render(const SE3<double>& T_world_cam, const ImageView<float>& gray, const ImageView<float>& depth) {
    render_bands(
        rows_, [&](double) { return T_world_cam; }, gray, depth);
  }
  /// The same while the camera moves: `T_world_cam(v)` when the row v is exposed.
  template <class PoseOfRow>
  void render_rolling(PoseOfRow&& T_world_cam, const ImageView<float>& gray, const ImageView<float>& depth) {
    render_bands(2, T_world_cam, gray, depth);
  }

  const Scene& scene() const { return scene_; }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  static constexpr int tile = 16;
  static constexpr float crack = 3e-5f;  ///< [m] by which rectangles are enlarged: neighbors leave no gap in float

  using Form = Vec<float, 3>;
  struct Projected {
    Form a, b, w;              ///< (1)
    std::array<Form, 4> side;  ///< (2) without w itself
    int id;
  };
  struct Bearings {
    std::vector<float> x, y, z;
    explicit Bearings(std::size_t n) : x(n), y(n), z(n) {}
    std::size_t size() const { return x.size(); }
    void set(int i, const Vec<float, 3>& b) {
      x[std::size_t(i)] = b.x(), y[std::size_t(i)] = b.y(), z[std::size_t(i)] = b.z();
    }
    Vec<float, 3> operator()(int i) const { return {x[std::size_t(i)], y[std::size_t(i)], z[std::size_t(i)]}; }
  };

  int index(int x, int y) const { return y * stride_ + x; }
  Vec<float, 3> step_x(int i) const { return bearings_(i + 1) - bearings_(i); }
  Vec<float, 3> step_y(int i) const { return bearings_(i + stride_) - bearings_(i); }

  template <class PoseOfRow>
  void render_bands(int band, PoseOfRow&& T_world_cam, const ImageView<float>& gray, const ImageView<float>& depth) {
    PLUMBLINE_ASSERT(gray.width == width_ && gray.height == height_ && depth.width == width_ &&
                     depth.height == height_);
    const auto prepare_band = [&](int top) { prepare(T_world_cam(top + 0.5 * (band - 1))); };
    const int tile_rows = std::min(tile, band);
    for (int top = 0; top < rows_; top += band) {
      prepare_band(top);
      for (int y = top; y < top + band; y += tile_rows) {
        for (int x = 0; x < stride_; x += tile) cast_tile(x, y, tile_rows);
      }
    }
    for (int top = 0; top < height_; top += band) {
      if (band < rows_) prepare_band(top);
      for (int y = top; y < std::min(top + band, height_); ++y) shade_row(y, gray.row(y), depth.row(y));
    }
  }

  void shade_row(int y, float* gray, float* depth) const {
    for (int x = 0; x < width_; ++x) {
      const int i = index(x, y), hit = surface_[std::size_t(i)];
      depth[x] = hit < 0 ? 0 : bearings_.z[std::size_t(i)] / inverse_range_[std::size_t(i)];
      gray[x] = on_edge(x, y) ? resolve_edge(x, y) : hit < 0 ? 0 : shade(hit, i, 0, 0);
    }
  }

  /// The forms (1), (2) of the rectangles that face the camera.
  void prepare(const SE3<double>& T_world_cam) {
    const Mat<double, 3, 3> R_cam_world = T_world_cam.R().transpose();
    projected_.clear();
    slot_.assign(scene_.rectangles.size(), -1);
    for (std::size_t id = 0; id < scene_.rectangles.size(); ++id) {
      const Rectangle& r = scene_.rectangles[id];
      const Vec<double, 3> o = R_cam_world * (r.origin - T_world_cam.p()), n = R_cam_world * r.normal();
      const Vec<double, 3> e_u = R_cam_world * r.e_u, e_v = R_cam_world * r.e_v;
      const double d = n.dot(o);
      if (!(d < -1e-6)) continue;
      Projected p;
      p.a = (e_u - e_u.dot(o) / d * n).cast<float>();
      p.b = (e_v - e_v.dot(o) / d * n).cast<float>();
      p.w = (n / d).cast<float>();
      const float width = static_cast<float>(r.width) + crack, height = static_cast<float>(r.height) + crack;
      p.side = {Form(p.a + crack * p.w), Form(width * p.w - p.a), Form(p.b + crack * p.w), Form(height * p.w - p.b)};
      p.id = static_cast<int>(id);
      slot_[id] = static_cast<int>(projected_.size());
      projected_.push_back(p);
    }
  }

  /// Nearest surface at the center of each pixel of a tile.
  void cast_tile(int x0, int y0, int rows) {
    Vec<float, 3> lo = bearings_(index(x0, y0)), hi = lo;
    for (int y = y0; y < y0 + rows; ++y) {
      std::fill_n(surface_.begin() + index(x0, y), tile, -1);
      std::fill_n(inverse_range_.begin() + index(x0, y), tile, 0.0f);
      for (int x = x0; x < x0 + tile; ++x) {
        const Vec<float, 3> b = bearings_(index(x, y));
        lo = lo.cwiseMin(b), hi = hi.cwiseMax(b);
      }
    }
    const Vec<float, 3> center = (lo + hi) / 2, half = (hi - lo) / 2;
    const auto middle = [&](const Form& f) { return f.x() * center.x() + f.y() * center.y() + f.z() * center.z(); };
    const auto radius = [&](const Form& f) {
      return std::abs(f.x()) * half.x() + std::abs(f.y()) * half.y() + std::abs(f.z()) * half.z();
    };
    visible_.clear();
    float covered = 0;  // inverse range of the farthest point of a surface that fills the whole tile
    for (std::size_t k = 0; k < projected_.size(); ++k) {
      const Projected& p = projected_[k];
      const float w = middle(p.w), w_radius = radius(p.w);
      if (!(w + w_radius > covered)) continue;
      bool some = true, all = w - w_radius > 0;
      for (const Form& f : p.side) {
        const float m = middle(f), r = radius(f);
        some = some && m + r > 0;
        all = all && m - r > 0;
        if (!some) break;
      }
      if (!some) continue;
      if (all) covered = std::max(covered, w - w_radius);
      visible_.push_back({w + w_radius, &p});
    }
    for (const auto& [nearest, p] : visible_) {
      if (nearest >= covered) cast(*p, x0, y0, rows);
    }
  }

  void cast(const Projected& p, int x0, int y0, int rows) {
    const Form f0 = p.side[0], f1 = p.side[1], f2 = p.side[2], f3 = p.side[3];
    for (int y = y0; y < y0 + rows; ++y) {
      const std::size_t begin = static_cast<std::size_t>(index(x0, y));
      const float *bx = &bearings_.x[begin], *by = &bearings_.y[begin], *bz = &bearings_.z[begin];
      float* nearest = &inverse_range_[begin];
      std::int32_t* id = &surface_[begin];
      for (int i = 0; i < tile; ++i) {
        const auto at = [&](const Form& f) { return f.x() * bx[i] + f.y() * by[i] + f.z() * bz[i]; };
        const float w = at(p.w), s0 = at(f0), s1 = at(f1), s2 = at(f2), s3 = at(f3);
        const bool hit = (w > nearest[i]) & (s0 > 0) & (s1 > 0) & (s2 > 0) & (s3 > 0);
        nearest[i] = hit ? w : nearest[i];
        id[i] = hit ? p.id : id[i];
      }
    }
  }

  bool on_edge(int x, int y) const {
    const std::int32_t *mid = &surface_[std::size_t(index(x, y))], *up = y > 0 ? mid - stride_ : mid,
                       *down = mid + stride_;
    const std::int32_t *l = x > 0 ? mid - 1 : mid, id = *mid;
    return l[0] != id || mid[1] != id || up[0] != id || down[0] != id || up[l - mid] != id || up[1] != id ||
           down[l - mid] != id || down[1] != id;
  }

  /// Radiance of surface `id` at the bearing of pixel i moved by (ox, oy) [px].
  float shade(int id, int i, float ox, float oy) const {
    const Projected& p = projected_[std::size_t(slot_[std::size_t(id)])];
    const Vec<float, 3> bx = step_x(i), by = step_y(i), b = bearings_(i) + ox * bx + oy * by;
    const float iw = 1 / p.w.dot(b), u = p.a.dot(b) * iw, v = p.b.dot(b) * iw;
    const float wx = p.w.dot(bx), wy = p.w.dot(by);
    return textures_[std::size_t(id)].sample(u, v, (p.a.dot(bx) - u * wx) * iw, (p.b.dot(bx) - v * wx) * iw,
                                             (p.a.dot(by) - u * wy) * iw, (p.b.dot(by) - v * wy) * iw);
  }

  /// Mean over 16 rays: each surface found in the neighborhood is shaded once, where its rays have their center.
  float resolve_edge(int x, int y) const {
    const int i = index(x, y);
    const Vec<float, 3> b = bearings_(i), bx = step_x(i), by = step_y(i);
    std::array<std::int32_t, 9> ids;
    int count = 0;
    bool open = false;  // the scene ends here: rays that miss see black
    for (int dy = y > 0 ? -1 : 0; dy <= 1; ++dy) {
      for (int dx = x > 0 ? -1 : 0; dx <= 1; ++dx) {
        const std::int32_t id = surface_[std::size_t(index(x + dx, y + dy))];
        open = open || id < 0;
        const bool faces = id >= 0 && slot_[std::size_t(id)] >= 0;  // another row's camera may see another side
        if (faces && std::find(ids.begin(), ids.begin() + count, id) == ids.begin() + count)
          ids[std::size_t(count++)] = id;
      }
    }
    std::array<float, rays> nearest{};
    std::array<int, rays> owner;
    owner.fill(-1);
    for (int k = 0; k < count; ++k) {
      const Projected& p = projected_[std::size_t(slot_[std::size_t(ids[std::size_t(k)])])];
      std::array<Vec<float, 3>, 5> f;  // each form as c0 + cx ox + cy oy
      for (std::size_t j = 0; j < 5; ++j) {
        const Form& form = j < 4 ? p.side[j] : p.w;
        f[j] = {form.dot(b), form.dot(bx), form.dot(by)};
      }
      for (std::size_t s = 0; s < rays; ++s) {
        const float ox = offset_x(s), oy = offset_y(s);
        const auto at = [&](std::size_t j) { return f[j].x() + ox * f[j].y() + oy * f[j].z(); };
        if (at(4) > nearest[s] && at(0) > 0 && at(1) > 0 && at(2) > 0 && at(3) > 0) nearest[s] = at(4), owner[s] = k;
      }
    }
    float sum = 0, total = 0;
    for (int k = 0; k < count; ++k) {
      float n = 0, ox = 0, oy = 0;
      for (std::size_t s = 0; s < rays; ++s) {
        if (owner[s] == k) n += 1, ox += offset_x(s), oy += offset_y(s);
      }
      if (n > 0) sum += n * shade(ids[std::size_t(k)], i, ox / n, oy / n), total += n;
    }
    return open ? sum / rays : total > 0 ? sum / total : 0;
  }
  /// Rays of a pixel [px]: a Hammersley set, with 16 different offsets along x and along y.
  static constexpr std::size_t rays = 16;
  static constexpr float offset_x(std::size_t s) { return (static_cast<float>(s) + 0.5f) / rays - 0.5f; }
  static constexpr float offset_y(std::size_t s) {
    return offset_x((s & 1) << 3 | (s & 2) << 1 | (s & 4) >> 1 | (s & 8) >> 3);
  }

  Scene scene_;
  int width_, height_, stride_, rows_;  ///< [px]; stride and rows: whole tiles, at least one pixel beyond the image
  Bearings bearings_;
  std::vector<Mipmap> textures_;  ///< one for each rectangle
  std::vector<Projected> projected_;
  std::vector<int> slot_;  ///< rectangle -> entry of projected_
  std::vector<std::pair<float, const Projected*>> visible_;
  std::vector<std::int32_t> surface_;  ///< rectangle seen by each pixel, -1: none
  std::vector<float> inverse_range_;   ///< [1/m]
};

}  // namespace plumbline::testing
