#include <concepts>

#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/systems/rgbd_inertial_vio.hpp"
#include "window.hpp"

using Sensors = pl::Rig<RgbdCamera, pl::Imu>;

// What goes by the name rgbd-inertial-vio is that system.
static_assert(
    std::same_as<pl::RgbdInertialVio<pl::AnyCamera<double>, max_pixels>,
                 pl::Estimator<Sensors, pl::Features<pl::Points<400>, pl::Lines<100>>, pl::SlidingWindow<10>>>);

std::unique_ptr<Runner> make_rgbd_imu_points_lines_window(const pl::io::Calibration& calibration) {
  return make_window<Sensors, pl::Points<400>, pl::Lines<100>>(calibration);
}
