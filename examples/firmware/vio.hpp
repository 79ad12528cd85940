#pragma once
/// The estimator of the example, the same on the microcontroller and on the host. FIRMWARE_DIRECT chooses.

#include "plumbline/camera/pinhole.hpp"
#include "plumbline/estimator/clock.hpp"
#include "plumbline/estimator/executor.hpp"
#ifdef FIRMWARE_DIRECT
#include "plumbline/systems/semi_direct_vio.hpp"
#else
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/map/no_map.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rig.hpp"
#endif
#include "recording.hpp"

using Camera = plumbline::Pinhole<float>;
using Sensors = plumbline::Rig<plumbline::Mono<Camera, 320 * 240>, plumbline::Imu>;
#ifdef FIRMWARE_DIRECT
template <plumbline::Executor Task>
using Vio = plumbline::SemiDirectVio<Camera, 320 * 240, plumbline::NoClock, plumbline::NoMap, Task>;
#else
template <plumbline::Executor Task>
using Vio = plumbline::Estimator<Sensors, plumbline::Features<plumbline::Points<100> >, plumbline::SlidingWindow<6>,
                                 plumbline::NoClock, plumbline::NoMap, Task>;
#endif

inline Sensors make_sensors(const RecordingHeader& from) {
  Sensors out{};
  out.vision.camera = {.fx = float(from.fx), .fy = float(from.fy), .cx = float(from.cx), .cy = float(from.cy)};
  out.vision.width = from.width;
  out.vision.height = from.height;
  const double* q = from.q_body_cam;
  const double* p = from.p_body_cam;
  out.imu.T_body_cam = {plumbline::SO3<double>(Eigen::Quaternion<double>(q[3], q[0], q[1], q[2])), {p[0], p[1], p[2]}};
  out.imu.noise = {.gyro_density = from.gyro_density,
                   .accel_density = from.accel_density,
                   .gyro_walk = from.gyro_walk,
                   .accel_walk = from.accel_walk,
                   .rate_hz = from.rate_hz};
  return out;
}

/// A frame is added when this much later IMU samples are there: the time offset is estimated, and may be positive.
inline constexpr plumbline::TimeNs imu_lead_ns = 10'000'000;

/// Whether all IMU samples of a frame have been added.
inline bool is_due(plumbline::TimeNs frame_ns, plumbline::TimeNs last_sample_ns) {
  return last_sample_ns >= frame_ns + imu_lead_ns;
}
