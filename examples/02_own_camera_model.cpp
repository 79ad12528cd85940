// A camera model of one's own: any type that satisfies the concept CameraModel takes part in everything. Here a
// stereographic fisheye lens follows a rendered room; the program fails when it ends far from the truth.
#include <cmath>
#include <cstdio>
#include <memory>

#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/testing/room_run.hpp"

namespace pl = plumbline;

/// Stereographic projection: a ray at angle theta from the axis is seen 2 f tan(theta/2) from the center.
///
///   uv = c + s (x, y),   s = 2 f/(r + z),   r = |p|                                                          (1)
///   J_uv_p = s [I2 0] - s/(r + z) (x, y)^T (p^T/r + e3^T)                                                    (2)
///   b = (2 m, 1 - |m|^2)/(1 + |m|^2),   m = (uv - c)/(2 f)                                                   (3)
template <std::floating_point S>
struct Stereographic {
  using Scalar = S;
  S f, cx, cy;  ///< [px]

  pl::Projection<S> project(const pl::Vec<S, 3>& p_cam) const {
    pl::Projection<S> out;
    const S r = p_cam.norm(), d = r + p_cam.z();
    out.valid = d > S(0.2) * r;  // up to 143 degrees from the axis; false for NaN
    if (!out.valid) return out;
    const S s = 2 * f / d;
    out.uv << cx + s * p_cam.x(), cy + s * p_cam.y();  // (1)
    const pl::Vec<S, 3> d_by_p = p_cam / r + pl::Vec<S, 3>::UnitZ();
    out.J_uv_p.noalias() = (-s / d) * p_cam.template head<2>() * d_by_p.transpose();
    out.J_uv_p.diagonal().array() += s;  // (2)
    return out;
  }

  pl::Unprojection<S> unproject(const pl::Vec<S, 2>& uv) const {
    pl::Unprojection<S> out;
    const pl::Vec<S, 2> m((uv.x() - cx) / (2 * f), (uv.y() - cy) / (2 * f));
    const S m2 = m.squaredNorm();
    out.valid = m2 < S(9);  // the domain of `project`
    out.bearing << 2 * m, 1 - m2;
    out.bearing /= 1 + m2;  // (3)
    return out;
  }
};
static_assert(pl::CameraModel<Stereographic<float>> && pl::CameraModel<Stereographic<double>>);

int main() {
  constexpr int width = 320, height = 240;
  using Camera = Stereographic<double>;
  using Sensors = pl::Rig<pl::Rgbd<Camera, width * height>>;
  using Vo = pl::Estimator<Sensors, pl::Features<pl::Points<200>>, pl::SlidingWindow<6>>;

  Sensors sensors{};
  sensors.vision.camera = Camera{190, 159.5, 119.5};
  sensors.vision.width = width;
  sensors.vision.height = height;
  const auto vo = std::make_unique<Vo>(sensors);

  const pl::testing::RoomRun run = pl::testing::run_in_room(*vo);  // the same model renders the room
  std::printf("%.2f m traveled, at most %.1f cm off\n", run.path_m, 100 * run.error_m);
  return run.is_within(0.03) ? 0 : 1;
}
