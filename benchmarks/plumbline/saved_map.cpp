#include "saved_map.hpp"

#include <cmath>
#include <cstdio>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "format.hpp"
#include "map_json.hpp"
#include "output_check.hpp"
#include "page.hpp"
#include "plumbline/io/map_file.hpp"
#include "plumbline/io/output_file.hpp"

namespace fs = std::filesystem;
namespace io = plumbline::io;
namespace pl = plumbline;

namespace {

using Point = pl::Vec<double, 3>;

const char* sensors_of(std::uint32_t dim) {
  switch (dim) {
    case 4: return "with an IMU: meters, z up";
    case 6: return "with depth, without an IMU: meters, axes of its first frame";
    default: return "a camera alone: unit and axes of its own";
  }
}

std::string numbers(const Point& p) { return format("%.9g %.9g %.9g", p.x(), p.y(), p.z()); }

struct MapExtent {
  std::set<std::uint32_t> worlds;
  std::size_t located = 0;  ///< features
  double path = 0;          ///< of the keyframes
  Point size;               ///< of a box around the points
};

MapExtent extent_of(const io::MapContents& map) {
  MapExtent out;
  Point low = Point::Constant(std::numeric_limits<double>::infinity()), high = -low;
  const io::MapContents::Keyframe* before = nullptr;
  for (const auto& entry : map.keyframes) {
    out.worlds.insert(entry.keyframe.world);
    if (before && before->keyframe.world == entry.keyframe.world)
      out.path += (entry.keyframe.S_map_body.t() - before->keyframe.S_map_body.t()).norm();
    before = &entry;
    entry.for_each_point([&](const pl::PlaceFeature&, const Point& p, double) {
      ++out.located;
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    });
  }
  out.size = out.located > 0 ? Point(high - low) : Point(0, 0, 0);
  return out;
}

void print(const fs::path& file, const io::MapContents& map) {
  const auto& [worlds, located, path, size] = extent_of(map);
  std::printf("%s: %zu keyframes of %zu worlds, %u features, %zu of them points, %zu loops; %ju bytes\n",
              file.string().c_str(), map.keyframes.size(), worlds.size(), map.header.features, located,
              map.loops.size(), static_cast<std::uintmax_t>(fs::file_size(file)));
  std::printf("made by a rig %s\n", sensors_of(map.header.dim));
  std::printf("path of the keyframes %.3f, extent of the points %.3f x %.3f x %.3f\n", path, size.x(), size.y(),
              size.z());
}

void write_ply(const fs::path& file, const io::MapContents& map) {
  std::vector<Point> points;
  for (const auto& entry : map.keyframes)
    entry.for_each_point([&](const pl::PlaceFeature&, const Point& p, double) { points.push_back(p); });
  io::OutputFile out(file);
  out.stream() << "ply\nformat ascii 1.0\nelement vertex " << points.size()
               << "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (const Point& p : points) out.stream() << numbers(p) << '\n';
  out.commit();
}

/// A pinhole camera without distortion for all keyframes, whose features are bearings.
void write_colmap(const fs::path& folder, const io::MapContents& map) {
  constexpr double focal = 1000, center = 1000;
  fs::create_directories(folder);
  io::OutputFile cameras(folder / "cameras.txt"), images(folder / "images.txt"), points(folder / "points3D.txt");
  cameras.stream() << "1 PINHOLE 2000 2000 1000 1000 1000 1000\n";
  std::size_t point = 0, image = 0;
  for (const auto& entry : map.keyframes) {
    ++image;
    const pl::Sim3<double>& S_map_body = entry.keyframe.S_map_body;
    const pl::SE3<double> T_map_cam(S_map_body.rotation() * entry.keyframe.T_body_cam.rotation(),
                                    S_map_body * entry.keyframe.T_body_cam.p());
    const pl::SE3<double> T_cam_map = T_map_cam.inverse();
    const Eigen::Quaterniond& q = T_cam_map.rotation().quaternion();
    images.stream() << format("%zu %.12g %.12g %.12g %.12g ", image, q.w(), q.x(), q.y(), q.z())
                    << numbers(T_cam_map.p()) << format(" 1 %lld.png\n", static_cast<long long>(entry.keyframe.t_ns));
    std::size_t seen = 0;
    entry.for_each_point([&](const pl::PlaceFeature& feature, const Point& p, double) {
      if (feature.bearing.z() < 0.1f) return;
      const double u = center + focal * double(feature.bearing.x() / feature.bearing.z());
      const double v = center + focal * double(feature.bearing.y() / feature.bearing.z());
      images.stream() << format("%s%.4f %.4f %zu", seen ? " " : "", u, v, ++point);
      points.stream() << point << ' ' << numbers(p) << format(" 128 128 128 0 %zu %zu\n", image, seen++);
    });
    images.stream() << '\n';
  }
  for (io::OutputFile* file : {&cameras, &images, &points}) file->complete();
  for (io::OutputFile* file : {&cameras, &images, &points}) file->commit();
}

/// Page `debug` without frames.
void write_report(const fs::path& html, const fs::path& file, const io::MapContents& map) {
  const auto& [worlds, located, path, size] = extent_of(map);
  nlohmann::json data{
      {"format", "plumbline-map"},      {"version", 1},
      {"title", file.string()},         {"summary", std::string("made by a rig ") + sensors_of(map.header.dim)},
      {"has_imu", map.header.dim == 4}, {"t", nlohmann::json::array()},
      {"map", json_of_map(map)}};
  data["map"]["counts"] = {{"keyframes", map.keyframes.size()},
                           {"worlds", worlds.size()},
                           {"features", map.header.features},
                           {"points", located},
                           {"loops", map.loops.size()}};
  data["map"]["path"] = path;
  data["map"]["extent"] = {size.x(), size.y(), size.z()};
  io::OutputFile out(html);
  write_page(out.stream(), "debug", data);
  out.commit();
}

}  // namespace

int print_saved_map(const SavedMapOptions& options) {
  const io::MapContents map = io::read_map(options.file);
  std::vector<NamedOutput> outputs;
  if (options.ply) outputs.push_back({"--ply", *options.ply});
  if (options.report) outputs.push_back({"--report", *options.report});
  check_outputs(outputs, {options.file});
  print(options.file, map);
  if (options.ply) write_ply(*options.ply, map);
  if (options.colmap) write_colmap(*options.colmap, map);
  if (options.report) write_report(*options.report, options.file, map);
  return 0;
}
