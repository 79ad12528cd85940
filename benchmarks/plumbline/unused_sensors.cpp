#include "unused_sensors.hpp"

#include <stdexcept>

namespace io = plumbline::io;

std::string why_no_imu(const io::Recording& recording) {
  const std::string file = recording.files().calibration.filename().string();
  if (!recording.files().imu_index) return "it has no IMU samples";
  if (!recording.calibration().imu) return file + " states no noise of the IMU (give imu.yaml with --imu-calibration)";
  if (!recording.calibration().T_body_camera)
    return file + " has no transform between camera and IMU (T_body_camera, T_cam_imu, T_imu_cam or T_BS)";
  return {};
}

std::string why_no_depth(const io::Recording& recording) {
  if (!recording.files().depth_index) return "it has no depth images";
  if (recording.calibration().depth_scale > 0) return {};
  return recording.files().calibration.filename().string() +
         " states no depth scale (give the raw units per meter with --depth-scale, often 1000)";
}

void require_sensors(const Configuration& configuration, const io::Recording& recording,
                     const std::filesystem::path& dataset) {
  if (configuration.needs.depth && !recording.has_depth())
    throw std::runtime_error(dataset.string() + ": " + configuration.name +
                             " needs depth images and the calibration's depth scale: " + why_no_depth(recording));
  if (configuration.needs.imu && !recording.has_imu())
    throw std::runtime_error(dataset.string() + ": " + configuration.name +
                             " needs IMU samples, their noise and T_body_camera: " + why_no_imu(recording));
}

std::string why_recommended(const Configuration& configuration, const io::Recording& recording) {
  const auto sensors = [](bool depth, bool imu) {
    return std::string("a camera") + (depth && imu ? ", depth and an IMU"
                                      : depth      ? " and depth"
                                      : imu        ? " and an IMU"
                                                   : "");
  };
  const Needs& needs = configuration.needs;
  std::string out = std::string(configuration.name) + ", recommended for " + sensors(needs.depth, needs.imu);
  if (needs.depth != recording.has_depth() || needs.imu != recording.has_imu())
    out += "; this program has none for " + sensors(recording.has_depth(), recording.has_imu());
  return out + " (--config NAME for another one, see plumbline list)";
}

std::vector<std::string> unusable_sensors(const io::Recording& recording) {
  std::vector<std::string> out;
  const auto add = [&](const std::filesystem::path& file, const std::string& why) {
    if (!why.empty()) out.push_back(file.string() + " is not used: " + why);
  };
  const io::RecordingFiles& files = recording.files();
  if (files.imu_index) add(*files.imu_index, why_no_imu(recording));
  if (files.depth_index) add(*files.depth_index, why_no_depth(recording));
  for (const std::filesystem::path& camera : files.other_sensors) add(camera, "one camera is read");
  return out;
}

std::vector<std::string> unused_sensors(const io::Recording& recording, const Configuration& configuration) {
  std::vector<std::string> out = unusable_sensors(recording);
  const auto add = [&](const std::filesystem::path& file, const char* sensor) {
    out.push_back(file.string() + " is not used: the configuration " + configuration.name + " is one without " +
                  sensor);
  };
  if (recording.has_imu() && !configuration.needs.imu) add(*recording.files().imu_index, "an IMU");
  if (recording.has_depth() && !configuration.needs.depth) add(*recording.files().depth_index, "depth");
  return out;
}
