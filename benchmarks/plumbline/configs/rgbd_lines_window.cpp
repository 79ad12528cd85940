#include "plumbline/feature/lines.hpp"
#include "window.hpp"

std::unique_ptr<Runner> make_rgbd_lines_window(const pl::io::Calibration& calibration) {
  return make_window<pl::Rig<RgbdCamera>, pl::Lines<160>>(calibration);
}
