#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/start_points.hpp"
#include "plumbline/sensor/imu.hpp"
#include "window.hpp"

std::unique_ptr<Runner> make_mono_imu_lines_window(const pl::io::Calibration& calibration) {
  return make_window<pl::Rig<MonoCamera, pl::Imu>, pl::StartPoints<200>, pl::Lines<100>>(calibration);
}
