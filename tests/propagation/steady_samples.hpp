#pragma once
// IMU samples of a body at rest or one that turns, integrated from frame to frame.

#include <functional>

#include "catch.hpp"
#include "plumbline/propagation/imu_integrator.hpp"

namespace plumbline::test {

template <class S>
struct SteadySamples {
  static constexpr TimeNs period = 5'000'000;

  ImuIntegrator<S> imu{Imu{},
                       ImuNoise{.gyro_density = 1e-3, .accel_density = 1e-2, .gyro_walk = 1e-5, .accel_walk = 1e-4}};
  std::function<Vec<double, 3>(double)> rate = [](double) { return Vec<double, 3>(0, 0, 0); };  ///< by time [s]
  Vec<double, 3> force{0, 0, 9.81};                                                             ///< [m/s^2]
  NavState<S> state;
  TimeNs now = 0;

  /// Samples up to the next frame, dt [s] later, integrated.
  void advance(double dt) {
    const TimeNs next = now + TimeNs(1e9 * dt);
    imu.begin_frame(now);
    for (TimeNs t = now == 0 ? 0 : now + period; t <= next; t += period) {
      const double wiggle = 1e-9 * double(t / period % 7);  // a live sensor does not repeat itself
      const Vec<double, 3> w = rate(1e-9 * double(t));
      REQUIRE(imu.add({t, {w.x() + wiggle, w.y(), w.z()}, {force.x(), force.y() + wiggle, force.z()}}, &state));
    }
    imu.integrate(next, state);
    now = next;
  }
};

}  // namespace plumbline::test
