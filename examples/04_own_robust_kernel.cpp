// A robust kernel of one's own: any type that satisfies the concept RobustLoss weighs what a feature kind measures, in
// the estimate of a frame and in the window alike. Here Welsch's, beyond which an outlier has hardly any weight.
#include <cmath>
#include <cstdio>
#include <memory>

#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/solver/robust_loss.hpp"
#include "plumbline/testing/room_run.hpp"

namespace pl = plumbline;

/// Welsch: rho = c^2 (1 - exp(-s/c^2)) of a whitened squared residual s. 95 % efficient for one row with c = 2.985.
template <class S>
struct Welsch {
  using Scalar = S;
  S c = S(2.985);
  S rho(S s) const { return -c * c * std::expm1(-s / (c * c)); }
  S weight(S s) const { return std::exp(-s / (c * c)); }             // rho'
  S second(S s) const { return -std::exp(-s / (c * c)) / (c * c); }  // rho''

  /// A kernel may be wider for residuals of more rows.
  template <int Rows>
  static constexpr Welsch for_rows() {
    return {Rows == 1 ? S(2.985) : S(3.5)};
  }
};
static_assert(pl::RobustLoss<Welsch<float>> && pl::RobustLoss<Welsch<double>>);

int main() {
  constexpr int width = 320, height = 240;
  using Sensors = pl::Rig<pl::Rgbd<pl::Pinhole<double>, width * height>>;
  using Vo = pl::Estimator<Sensors, pl::Features<pl::Points<200, Welsch>>, pl::SlidingWindow<6>>;

  Sensors sensors{};
  sensors.vision.camera = {268, 268, 159.5, 119.5, {}};
  sensors.vision.width = width;
  sensors.vision.height = height;
  const auto vo = std::make_unique<Vo>(sensors);

  const pl::testing::RoomRun run = pl::testing::run_in_room(*vo);
  std::printf("%.2f m traveled, at most %.1f cm off\n", run.path_m, 100 * run.error_m);
  return run.is_within(0.03) ? 0 : 1;
}
