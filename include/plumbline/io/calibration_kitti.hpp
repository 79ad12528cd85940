#pragma once
/// Calibrations of KITTI, of the rectified camera 0: calib.txt of the odometry recordings (P0), and
/// calib_cam_to_cam.txt of the raw ones (P_rect_00) with calib_velo_to_cam.txt and calib_imu_to_velo.txt beside it.
/// Lines are `key: numbers`.
///                                                                                     docs/guide/your_recording.md

#include <algorithm>
#include <filesystem>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "plumbline/io/calibration_checks.hpp"
#include "plumbline/opencv/image_file.hpp"

namespace plumbline::io::detail {

/// The `n` numbers behind a key, separated by blanks.
inline std::vector<double> kitti_numbers(const YamlMap& map, const char* key, std::size_t n) {
  std::istringstream text(map.text(key));
  std::vector<double> out;
  for (std::string word; text >> word;) {
    const std::optional<double> value = parse_finite(word);
    if (!value) map.fail(key, "has \"" + word + "\", which is not a finite number");
    out.push_back(*value);
  }
  if (out.size() != n) map.fail(key, "must have " + std::to_string(n) + " values, has " + std::to_string(out.size()));
  return out;
}

/// R (9 values, row by row) and T (3 values) of a file.
inline SE3<double> kitti_transform(const YamlMap& map) {
  const std::vector<double> R = kitti_numbers(map, "R", 9), t = kitti_numbers(map, "T", 3);
  return rigid_transform(map, "R",
                         {R[0], R[1], R[2], t[0], R[3], R[4], R[5], t[1], R[6], R[7], R[8], t[2], 0, 0, 0, 1});
}

/// fx fy cx cy of a rectified camera at the origin, from its 3x4 projection.
inline void set_kitti_projection(CameraCalibration& camera, const YamlMap& map, const char* key) {
  const std::vector<double> P = kitti_numbers(map, key, 12);
  camera.intrinsics = {P[0], P[5], P[2], P[6]};
  if (P[1] != 0 || P[4] != 0 || P[8] != 0 || P[9] != 0 || P[10] != 1)
    map.fail(key, "must be [fx 0 cx ..; 0 fy cy ..; 0 0 1 ..]");
}

/// calib.txt states no size of the images: it is that of the first one in image_0/ beside the file.
inline Calibration read_kitti_odometry(const YamlMap& root) {
  Calibration out;
  set_kitti_projection(out.camera, root, "P0");
  const std::filesystem::path folder = root.file().parent_path() / "image_0";
  std::vector<std::filesystem::path> images;
  if (std::filesystem::is_directory(folder))
    for (const auto& entry : std::filesystem::directory_iterator(folder)) images.push_back(entry.path());
  if (images.empty())
    throw ReadError(root.file(), 0,
                    "KITTI's calib.txt states no image size, and there is no image in image_0/ beside it: put it into "
                    "the folder of its sequence");
  const cv::Mat image = opencv::read_gray(*std::min_element(images.begin(), images.end()));
  out.camera.width = image.cols;
  out.camera.height = image.rows;
  check_projection(out.camera, root, "P0", "P0");
  return out;
}

/// T_cam0rect_imu = R_rect_00 T_cam0_velo T_velo_imu, where both files are there.
inline Calibration read_kitti_raw(const YamlMap& root) {
  Calibration out;
  CameraCalibration& camera = out.camera;
  set_kitti_projection(camera, root, "P_rect_00");
  const std::vector<double> size = kitti_numbers(root, "S_rect_00", 2);
  camera.width = static_cast<int>(size[0]);
  camera.height = static_cast<int>(size[1]);
  check_projection(camera, root, "P_rect_00", "S_rect_00");
  out.notes.push_back(root.note("P_rect_00", "is taken: the images are expected to be rectified"));
  const std::filesystem::path folder = root.file().parent_path();
  const std::filesystem::path velo_to_cam = folder / "calib_velo_to_cam.txt",
                              imu_to_velo = folder / "calib_imu_to_velo.txt";
  if (!std::filesystem::exists(velo_to_cam) || !std::filesystem::exists(imu_to_velo)) return out;
  const std::vector<double> R = kitti_numbers(root, "R_rect_00", 9);
  const SE3<double> T_rect_cam =
      rigid_transform(root, "R_rect_00", {R[0], R[1], R[2], 0, R[3], R[4], R[5], 0, R[6], R[7], R[8], 0, 0, 0, 0, 1});
  const SE3<double> T_rect_imu =
      T_rect_cam * kitti_transform(YamlMap(velo_to_cam)) * kitti_transform(YamlMap(imu_to_velo));
  out.T_body_camera = T_rect_imu.inverse();
  return out;
}

}  // namespace plumbline::io::detail
