#include "calibrated_sensors.hpp"

#include <cmath>
#include <string>

#include "plumbline/io/error.hpp"

namespace io = plumbline::io;

void require_calibrated(const Configuration& configuration, const io::Calibration& calibration,
                        const std::filesystem::path& file) {
  const auto fail = [&](const std::string& what) {
    throw io::ReadError(file, 0, std::string(configuration.name) + " needs " + what);
  };
  if (configuration.needs.depth && !(calibration.depth_scale > 0))
    fail("the calibration's depth scale: it states none (raw units per meter, often 1000)");
  if (configuration.needs.imu && !calibration.imu)
    fail("the noise of the IMU: it states none (give imu.yaml beside the calibration of the camera)");
  if (configuration.needs.imu && !calibration.T_body_camera)
    fail("the transform between camera and IMU: it has none (T_body_camera, T_cam_imu, T_imu_cam or T_BS)");
}

plumbline::TimeNs frame_time(const Needs& needs, const io::Calibration& calibration, plumbline::TimeNs stamp_ns) {
  return needs.imu ? stamp_ns + std::llround(calibration.camera_time_offset_s * 1e9) : stamp_ns;
}
