// Writes the inputs of the corpora `map`, `bag` and `image` into folders of these names: write_corpus FOLDER.
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <opencv2/imgcodecs.hpp>

#include "io/bag/bag_writer.hpp"
#include "map/simulated_places.hpp"
#include "plumbline/map/keyframe_map.hpp"

namespace pl = plumbline;
namespace fs = std::filesystem;

namespace {

void write(const fs::path& file, const std::string& bytes) {
  fs::create_directories(file.parent_path());
  test::write_bytes(file, bytes);
}

/// Twice round a room, with loops.
template <class Residual>
std::string map_bytes() {
  using Core = pl::KeyframeMapCore<Residual, 24, 48, 8>;
  using S = typename Core::S;
  constexpr int per_lap = 5, count = 12, window = 2;
  const auto map = std::make_unique<Core>(pl::KeyframeMapOptions{});
  if (Core::Places::has_gravity) map->change_world({pl::WorldChange<S>::Kind::transformed, {}, {}});
  pl::test::SimulatedPlaces places(1);
  places.furnish(250, 6);
  std::vector<pl::SE3<S>> poses;
  for (int k = 0; k < count; ++k) {
    const double a = 2 * 3.14159265358979 * k / per_lap;
    const pl::SE3<double> T = pl::test::looking_along(a, {std::cos(a), std::sin(a), 0});
    pl::Mat<S, 6, 6> covariance = pl::zeros<S, 6, 6>();
    for (int i = 0; i < 6; ++i) covariance(i, i) = S(1e-4 * (1 + k));
    poses.push_back(T.cast<S>());
    pl::FixedVector<pl::PlaceFeature, 1000> features;
    places.look(T, features);
    if (auto* keyframe =
            map->begin_keyframe(std::uint32_t(k) + 1, pl::TimeNs(k) * 100'000'000, poses.back(), {}, covariance)) {
      for (std::size_t n = 0; n < features.size() && n < 30; ++n) keyframe->features.push_back(features[n]);
      map->finish_keyframe();
    }
    if (k >= window) map->retire(std::uint32_t(k - window) + 1, poses[std::size_t(k - window)]);
    for (int frame = 0; frame < 8; ++frame) map->work();
  }
  std::string bytes;
  map->save(
      [&](std::span<const std::byte> part) { bytes.append(reinterpret_cast<const char*>(part.data()), part.size()); });
  std::printf("map of %d keyframes and %d loops: %zu bytes\n", map->places().size(), map->counts().loops, bytes.size());
  return bytes;
}

void write_bags(const fs::path& folder) {
  using test::WrittenMessage;
  for (const test::BagFormat& format : test::bag_formats) {
    const auto s = format.serialization;
    constexpr int w = 8, h = 6;
    std::vector<WrittenMessage> messages{
        {0, "/cam/camera_info", "CameraInfo", test::camera_info_message(s, test::begin_ns, w, h)}};
    for (int i = 0; i < 2; ++i) {
      const pl::TimeNs t = test::frame_ns(i);
      messages.push_back({t, "/imu", "Imu", test::imu_message(s, t, 0.1 * i, 9.81)});
      messages.push_back(
          {t, "/cam/image_raw", "Image", test::image_message(s, t, w, h, "mono8", std::string(w * h, 'a'))});
      messages.push_back(
          {t, "/cam/depth", "Image", test::image_message(s, t, w, h, "16UC1", std::string(2 * w * h, '\7'))});
    }
    const std::string name = format.name + (format.compression.empty() ? "" : "_" + format.compression);
    const fs::path file = folder / name;
    fs::create_directories(folder);
    test::write_bag(file, format, messages);
    if (format.name == "sqlite") {  // small pages
      sqlite3* database = nullptr;
      sqlite3_open(file.c_str(), &database);
      if (sqlite3_exec(database, "PRAGMA page_size=512; VACUUM", nullptr, nullptr, nullptr) != SQLITE_OK)
        throw std::runtime_error(sqlite3_errmsg(database));
      sqlite3_close(database);
    }
    if (name == "mcap_none") {  // without the checksum of the chunk, which damaged contents would not pass
      std::string bytes = test::bytes_of(file);
      constexpr std::size_t head = 1 + 8, chunk = 8 + head + 2 * 4 + 4 + 4;  // after the magic and the header
      bytes.replace(chunk + head + 16 + 8, 4, 4, '\0');
      test::write_bytes(file, bytes);
    }
  }
}

void write_images(const fs::path& folder) {
  cv::Mat gray(12, 16, CV_8U), wide(12, 16, CV_16U), color(12, 16, CV_8UC3);
  for (cv::Mat* image : {&gray, &wide, &color}) cv::randu(*image, 0, image->depth() == CV_16U ? 4096 : 255);
  const auto encode = [&](const char* extension, const cv::Mat& image, const std::vector<int>& how = {}) {
    std::vector<std::uint8_t> bytes;
    cv::imencode(extension, image, bytes, how);
    return std::string(bytes.begin(), bytes.end());
  };
  write(folder / "gray_png", encode(".png", gray));
  write(folder / "gray16_png", encode(".png", wide));
  write(folder / "color_png", encode(".png", color));
  write(folder / "gray_jpeg", encode(".jpg", gray));
  write(folder / "color_jpeg", encode(".jpg", color));
  write(folder / "progressive_jpeg", encode(".jpg", color, {cv::IMWRITE_JPEG_PROGRESSIVE, 1}));
  write(folder / "restart_jpeg", encode(".jpg", gray, {cv::IMWRITE_JPEG_RST_INTERVAL, 1}));
  write(folder / "gray_pgm", encode(".pgm", gray));
  write(folder / "gray16_pgm", encode(".pgm", wide));
  write(folder / "ascii_pgm", encode(".pgm", gray, {cv::IMWRITE_PXM_BINARY, 0}));
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) return 2;
  const fs::path folder = arguments[1];
  write(folder / "map/metric", map_bytes<pl::RelativePoseResidual<double>>());
  write(folder / "map/inertial", map_bytes<pl::RelativePoseYawResidual<float>>());
  write(folder / "map/mono", map_bytes<pl::RelativeSim3Residual<float>>());
  write_bags(folder / "bag");
  write_images(folder / "image");
  return 0;
}
