#pragma once
// What every camera model must satisfy, whatever its equations.

#include <algorithm>
#include <limits>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

namespace plumbline::testing {

/// `make(S{})` returns the camera with scalar S. Every pixel of the image must have a bearing, unless it is outside the
/// lens circle of radius `circle_px` around (cx, cy).
template <class S, class Make>
void check_camera(const Make& make, int width, int height, double cx, double cy, double circle_px = 1e9) {
  const auto camera = make(S{});
  const auto exact = make(double{});
  const bool single = std::is_same_v<S, float>;

  double worst_round_trip = 0, worst_projection = 0, worst_bearing = 0, worst_unit = 0;
  int unprojected = 0, expected = 0;
  for (int v = 0; v < height; v += 7) {
    for (int u = 0; u < width; u += 7) {
      const Vec<S, 2> uv{S(u), S(v)};
      if (std::hypot(u - cx, v - cy) > circle_px) continue;
      ++expected;
      const Unprojection<S> ray = camera.unproject(uv);
      if (!ray.valid) continue;
      const Projection<S> pixel = camera.project(Vec<S, 3>(S(2.5) * ray.bearing));
      if (!pixel.valid) continue;
      ++unprojected;
      worst_round_trip = std::max(worst_round_trip, double((pixel.uv - uv).norm()));
      worst_unit = std::max(worst_unit, std::abs(double(ray.bearing.norm()) - 1));

      const Projection<S> at_bearing = camera.project(ray.bearing);
      const auto project = [&](const Vec<double, 3>& p) { return exact.project(p).uv; };
      const auto unproject = [&](const Vec<double, 2>& x) { return exact.unproject(x).bearing; };
      worst_projection =
          std::max(worst_projection,
                   jacobian_error(at_bearing.J_uv_p, project, Vec<double, 3>(ray.bearing.template cast<double>())));
      const Mat<S, 3, 2> J_bearing = bearing_jacobian<S>(at_bearing.J_uv_p);
      const double focal = double(effective_focal_length(camera));  // makes the entries comparable to 1
      const double step = 0.01 * focal;
      if (exact.unproject(Vec<double, 2>(uv.template cast<double>() + Vec<double, 2>::Constant(2 * step))).valid) {
        const Mat<double, 3, 2> numeric =
            numeric_jacobian<3, 2>(unproject, Vec<double, 2>(uv.template cast<double>()), 1e-2);
        worst_bearing = std::max(worst_bearing, focal * (numeric - J_bearing.template cast<double>()).norm());
      }
    }
  }
  CAPTURE(worst_round_trip, worst_projection, worst_bearing, worst_unit);
  CHECK(expected > 100);
  CHECK(unprojected == expected);
  CHECK(worst_round_trip < (single ? 2e-3 : 1e-8));
  CHECK(worst_unit < (single ? 1e-6 : 1e-14));
  CHECK(worst_projection < (single ? 2e-4 : 1e-7));
  CHECK(worst_bearing < (single ? 1e-3 : 1e-7));

  // A NaN anywhere is invalid, never an answer; so is the camera center.
  const S nan = std::numeric_limits<S>::quiet_NaN(), infinity = std::numeric_limits<S>::infinity();
  for (int i = 0; i < 3; ++i) {
    Vec<S, 3> p(S(0.1), S(-0.2), S(1));
    p[i] = nan;
    CHECK(!camera.project(p).valid);
  }
  CHECK(!camera.project(Vec<S, 3>::Zero()).valid);
  for (int i = 0; i < 2; ++i) {
    for (const S bad : {nan, infinity}) {
      Vec<S, 2> uv{S(cx), S(cy)};
      uv[i] = bad;
      CHECK(!camera.unproject(uv).valid);
    }
  }

  // Straight behind is never visible; whatever is called valid is finite, and its pixel leads back to the same bearing.
  CHECK(!camera.project(Vec<S, 3>(0, 0, -1)).valid);
  Random random(1);
  for (int i = 0; i < 5000; ++i) {
    const Vec<double, 3> direction{2 * random.uniform() - 1, 2 * random.uniform() - 1, 2 * random.uniform() - 1};
    const Vec<S, 3> p = direction.normalized().cast<S>();
    const Projection<S> pixel = camera.project(p);
    if (!pixel.valid) continue;
    REQUIRE(pixel.uv.allFinite());
    REQUIRE(pixel.J_uv_p.allFinite());
    REQUIRE((pixel.J_uv_p * p).norm() < S(1e-4) * pixel.J_uv_p.norm());  // depth does not move the pixel
    if ((pixel.uv - Vec<S, 2>(S(cx), S(cy))).norm() > S(std::min(circle_px, 1.0 * width))) continue;
    const Unprojection<S> ray = camera.unproject(pixel.uv);
    if (ray.valid) CHECK((ray.bearing - p).norm() < (single ? S(1e-3) : S(1e-9)));
  }
  const Projection<S> axis = camera.project(Vec<S, 3>(0, 0, 2));
  REQUIRE(axis.valid);
  CHECK((axis.uv - Vec<S, 2>(S(cx), S(cy))).norm() < S(1e-3));
  const auto project = [&](const Vec<double, 3>& p) { return exact.project(p).uv; };
  CHECK(jacobian_error(axis.J_uv_p, project, Vec<double, 3>(0, 0, 2)) < (single ? 1e-5 : 1e-8));
}

}  // namespace plumbline::testing
