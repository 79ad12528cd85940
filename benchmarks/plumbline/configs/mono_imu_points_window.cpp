#include "estimator_runner.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/any_camera.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rig.hpp"

namespace pl = plumbline;

using Sensors = pl::Rig<pl::Mono<pl::AnyCamera<double>, 1280 * 800>, pl::Imu>;
using Vio = pl::Estimator<Sensors, pl::Features<pl::Points<400>>, pl::SlidingWindow<10>, SteadyClock>;

std::unique_ptr<Runner> make_mono_imu_points_window(const pl::io::Calibration& calibration) {
  return std::make_unique<EstimatorRunner<Vio, Sensors>>(make_sensors<Sensors>(calibration));
}
