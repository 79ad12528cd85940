// How many points are on a collinear line, and what lines with few of them are worth: the histogram, and a sweep over
// the fewest points of a line, for a camera alone with a window, without and with a map. Prints tables in Markdown.
//
//   bench_opencv_collinear_lines <directory of a recording> ...
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/any_camera.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/collinear.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/io/make_camera.hpp"
#include "plumbline/io/recording.hpp"
#include "plumbline/io/trajectory_evaluation.hpp"
#include "plumbline/map/keyframe_map.hpp"
#include "plumbline/map/no_map.hpp"
#include "plumbline/opencv/image_file.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {
namespace {

constexpr std::size_t max_pixels = 1280 * 800, starts = 4;
constexpr std::size_t most_points = 12;                                                     // CollinearKind::max_points
constexpr std::array<std::size_t, 8> fewest_points{2, 3, 4, 5, 6, 8, 10, most_points + 1};  // the last: no lines
using Sensors = Rig<Mono<AnyCamera<double>, max_pixels, Rolling>>;
template <class Map>
using Odometry = Estimator<Sensors, Features<Points<400>, Collinear<100>>, SlidingWindow<10>, NoClock, Map>;

struct Pictures {
  io::Recording recording;
  io::Trajectory truth;
  std::vector<cv::Mat> gray;

  explicit Pictures(const char* directory)
      : recording(io::Recording::open(directory)), truth(recording.read_groundtruth(false).value()) {
    for (const io::FrameSample& sample : recording.frames()) gray.push_back(opencv::read_gray(sample.image));
  }
};

struct Outcome {
  double rmse_m = std::numeric_limits<double>::infinity();
  double coverage = 0;
  std::map<std::uint32_t, std::size_t> points_of;  // the most that a located line has had
};

/// Of the frames from `first` on. Poses are those that are published, in the map where there is one.
template <class Map>
Outcome run(const Pictures& pictures, std::size_t first, std::size_t fewest) {
  using Vo = Odometry<Map>;
  const io::CameraCalibration& calibration = pictures.recording.calibration().camera;
  Sensors sensors{};
  sensors.vision.camera = io::make_camera<double>(calibration);
  sensors.vision.width = calibration.width;
  sensors.vision.height = calibration.height;
  if (calibration.readout_s) sensors.vision.readout.set({*calibration.readout_s, 0});
  typename Vo::Options options;
  options.collinear.min_points = fewest;
  const auto vo = std::make_unique<Vo>(sensors, options);

  Outcome out;
  io::Trajectory poses;
  const auto& frames = pictures.recording.frames();
  for (std::size_t i = first; i < frames.size(); ++i) {
    const auto estimate = vo->add_frame({frames[i].t_ns, opencv::view<std::uint8_t>(pictures.gray[i])});
    if (!estimate) continue;
    vo->landmarks().for_each([&](const auto& store) {
      if constexpr (HasMembers<typename std::remove_cvref_t<decltype(store)>::Kind>) {
        for (const auto& line : store.landmarks()) {
          if (!line.located) continue;
          std::size_t& most = out.points_of[line.id];
          most = std::max(most, line.appearance.points.size());
        }
      }
    });
    if (estimate->health.state == HealthState::initializing || estimate->health.state == HealthState::lost) continue;
    const Sim3<double> S = vo->map().S_map_world() * Sim3<double>(estimate->T_world_body);
    poses.push_back({estimate->t_ns, SE3<double>(S.rotation(), S.t())});
  }
  out.coverage = double(poses.size()) / double(frames.size() - first);
  try {
    out.rmse_m =
        io::evaluate_trajectory(pictures.truth, poses, {.alignment = io::Alignment::sim3}).ape.translation.rmse;
  } catch (const std::exception&) {  // too few poses: a failed run
  }
  return out;
}

double middle(std::vector<double> x) {
  std::sort(x.begin(), x.end());
  return (x[(x.size() - 1) / 2] + x[x.size() / 2]) / 2;
}
std::string cell(const std::array<Outcome, starts>& runs) {
  std::vector<double> rmse, lines;
  for (const Outcome& one : runs) {
    rmse.push_back(one.rmse_m);
    lines.push_back(double(one.points_of.size()));
  }
  char text[80];
  std::snprintf(text, sizeof text, "%.4f m, worst %.4f m, %.0f lines", middle(rmse),
                *std::max_element(rmse.begin(), rmse.end()), middle(lines));
  return text;
}

void report(const char* directory) {
  const Pictures pictures(directory);
  std::string name = std::filesystem::path(directory).filename().string();
  std::printf("\n`%s`\n\n| fewest points | window | window and map |\n| --- | --- | --- |\n", name.c_str());
  std::array<std::size_t, most_points + 1> histogram{};
  double coverage = 1;
  for (const std::size_t fewest : fewest_points) {
    std::array<Outcome, starts> alone, mapped;
    for (std::size_t k = 0; k < starts; ++k) {
      alone[k] = run<NoMap>(pictures, k, fewest);
      mapped[k] = run<KeyframeMap<200>>(pictures, k, fewest);
      coverage = std::min(coverage, alone[k].coverage);
      if (fewest > fewest_points.front()) continue;
      for (const auto& [id, points] : alone[k].points_of) ++histogram[points];
    }
    std::printf("| %zu | %s | %s |\n", fewest, cell(alone).c_str(), cell(mapped).c_str());
    std::fflush(stdout);
  }
  std::printf("\nlowest coverage %.0f %%; lines by their points:", 100 * coverage);
  for (std::size_t n = 2; n <= most_points; ++n)
    std::printf(" %zu: %zu%s", n, histogram[n], n < most_points ? "," : "");
  std::printf("\n");
}

}  // namespace
}  // namespace plumbline

int main(int argc, char** argv) try {
  for (int k = 1; k < argc; ++k) plumbline::report(argv[k]);
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
