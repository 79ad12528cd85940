#pragma once
// Frames to align: a random motion with exact IMU samples, camera poses from its truth.

#include <span>
#include <vector>

#include "imu/random_motion.hpp"
#include "plumbline/imu/alignment_frame.hpp"
#include "plumbline/imu/gravity.hpp"
#include "plumbline/imu/preintegration.hpp"

namespace plumbline::test {

template <class S>
struct SimulatedAlignment {
  using P = Preintegration<S>;

  std::vector<NavState<double>> truth;  ///< of the body in the world
  std::vector<P> imu;
  std::vector<AlignmentFrame<P>> frames;
  SE3<double> T_body_cam{SO3<double>::exp({0.4, -1.2, 0.9}), {0.1, -0.05, 0.2}};
  SO3<double> R_ref_world = SO3<double>::exp({-1, 0.3, 2});

  /// Camera poses in a frame of their own, in units of `scale` meters. Without shaking the body is stationary.
  SimulatedAlignment(std::uint64_t seed, double scale, const Vec<double, 3>& bias_gyro,
                     const Vec<double, 3>& bias_accel, int count = 10, bool shaken = true, TimeNs step = 200'000'000) {
    testing::Gaussian normal(seed);
    const RandomMotion motion(normal);
    NavState<double> x = random_state(normal);
    x.T_world_body = SE3<double>(x.T_world_body.rotation(), Vec<double, 3>::Zero());
    x.bias_gyro = bias_gyro;
    x.bias_accel = bias_accel;
    if (!shaken) x.v_world_body.setZero();
    const Vec<double, 3> g = gravity_in_world<double>(),
                         is_stationary = x.T_world_body.rotation().inverse() * Vec<double, 3>(-g);
    for (int k = 0; k < count; ++k) {
      imu.emplace_back(ImuNoise{});
      if (k > 0) {
        ImuIncrement<double> exact(bias_gyro, bias_accel);
        for_each_interval(motion, k * step, (k + 1) * step, 40, [&](ImuInterval<double> d) {
          if (!shaken) {
            d.gyro_begin = d.gyro_end = Vec<double, 3>::Zero();
            d.accel_begin = d.accel_end = is_stationary;
          }
          d.gyro_begin += bias_gyro, d.gyro_end += bias_gyro;
          d.accel_begin += bias_accel, d.accel_end += bias_accel;
          exact.integrate(d, {});
          imu.back().add(d.template cast<S>());
        });
        x = exact.predict(x, g);
      }
      truth.push_back(x);
    }
    for (int k = 0; k < count; ++k) {
      const SE3<double> T_world_cam = truth[std::size_t(k)].T_world_body * T_body_cam;
      const SE3<double> T_ref_cam(R_ref_world * T_world_cam.rotation(),
                                  R_ref_world * Vec<double, 3>(T_world_cam.p() / scale) + Vec<double, 3>(1, 2, 3));
      frames.push_back({T_ref_cam.cast<S>(), &imu[std::size_t(k)]});
    }
  }
  SimulatedAlignment(const SimulatedAlignment&) = delete;

  std::span<const AlignmentFrame<P>> span() const { return frames; }
};

}  // namespace plumbline::test
