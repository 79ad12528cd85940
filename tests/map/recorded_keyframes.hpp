#pragma once
// Keyframes of a recording for place recognition: time, true pose and descriptors of every n-th image. Layouts: TUM
// (rgb.txt, groundtruth.txt) and EuRoC (mav0/cam0, mav0/state_groundtruth_estimate0). And the figure that a place index
// is judged by: recall at full precision.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "plumbline/core/matrix.hpp"
#include "plumbline/image/pyramid.hpp"
#include "plumbline/map/place_index.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/tracking/orb_features.hpp"

namespace plumbline::testing {

struct RecordedKeyframe {
  double t_s = 0;
  Vec<double, 3> p{0, 0, 0};
  Eigen::Quaternion<double> q = Eigen::Quaternion<double>::Identity();
  std::vector<BinaryDescriptor> descriptors;
};

/// Whether the poses are that near.
inline bool is_near(const RecordedKeyframe& a, const RecordedKeyframe& b, double distance_m, double angle_deg) {
  return (a.p - b.p).norm() < distance_m && a.q.angularDistance(b.q) * 180 / 3.14159265358979 < angle_deg;
}

/// Rows of numbers behind a time stamp, as the words of a line; commas are spaces.
inline std::vector<std::vector<std::string>> table_rows(const std::filesystem::path& file) {
  std::vector<std::vector<std::string>> rows;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    std::vector<std::string>& row = rows.emplace_back();
    for (std::string word; words >> word;) row.push_back(word);
  }
  return rows;
}

/// Every `every`-th image that has a true pose within 30 ms; nothing when the folder is not such a recording.
inline std::vector<RecordedKeyframe> recorded_keyframes(const std::filesystem::path& folder, std::size_t every) {
  const bool is_tum = std::filesystem::exists(folder / "rgb.txt");
  const std::filesystem::path images = is_tum ? folder : folder / "mav0/cam0/data";
  const auto image_rows = table_rows(is_tum ? folder / "rgb.txt" : folder / "mav0/cam0/data.csv");
  const auto pose_rows =
      table_rows(is_tum ? folder / "groundtruth.txt" : folder / "mav0/state_groundtruth_estimate0/data.csv");
  const double unit = is_tum ? 1 : 1e-9;
  std::map<double, RecordedKeyframe> poses;
  for (const auto& row : pose_rows) {
    if (row.size() < 8) continue;
    const auto number = [&](std::size_t i) { return std::stod(row[i]); };
    RecordedKeyframe pose;
    pose.t_s = unit * number(0);
    pose.p = {number(1), number(2), number(3)};
    pose.q = is_tum ? Eigen::Quaternion<double>(number(7), number(4), number(5), number(6))
                    : Eigen::Quaternion<double>(number(4), number(5), number(6), number(7));
    poses[pose.t_s] = pose;
  }
  const auto pyramid = std::make_unique<Pyramid<4, 1300 * 480>>();
  const auto features = std::make_unique<FixedVector<OrbFeature, 300>>();
  std::vector<RecordedKeyframe> out;
  for (std::size_t i = 0; i < image_rows.size(); i += every) {
    const double t_s = unit * std::stod(image_rows[i].at(0));
    const auto pose = poses.lower_bound(t_s - 0.03);
    if (pose == poses.end() || pose->first > t_s + 0.03) continue;
    const cv::Mat image = cv::imread((images / image_rows[i].at(1)).string(), cv::IMREAD_GRAYSCALE);
    if (image.empty() || !pyramid->build(opencv::view<std::uint8_t>(image))) continue;
    features->clear();
    add_corner_features(*pyramid, OrbFeatureOptions{}, *features);
    RecordedKeyframe keyframe =
        poses.lower_bound(t_s - 0.001) == poses.end() ? pose->second : poses.lower_bound(t_s - 0.001)->second;
    keyframe.t_s = t_s;
    for (const OrbFeature& feature : *features) keyframe.descriptors.push_back(feature.descriptor);
    out.push_back(std::move(keyframe));
  }
  return out;
}

/// Each keyframe asks for the most similar one among those at least `gap_s` older and the background (other scenes).
struct PlaceRecall {
  int revisits = 0;     ///< queries with a keyframe within 1 m and 30 degrees to be found
  double first = 0;     ///< part of them whose best candidate is one of those
  double strict = 0;    ///< the same, with a score above that of all candidates further than 1 m or 30 degrees
  double recall = 0;    ///< the same, with a score above that of all candidates further than 2 m or 60 degrees
  float threshold = 0;  ///< the highest score of a candidate further than 2 m or 60 degrees
};

template <PlaceIndex Index>
PlaceRecall place_recall(Index& index, std::span<const RecordedKeyframe> run,
                         std::span<const RecordedKeyframe> background, double gap_s = 2.5) {
  index.clear();
  const auto n = static_cast<std::uint32_t>(run.size());
  for (std::uint32_t i = 0; i < background.size(); ++i) index.add(n + i, background[i].descriptors);
  std::vector<PlaceCandidate> best(run.size(), {n, 0});
  PlaceRecall out;
  float strict_threshold = 0;
  std::vector<bool> has_place(run.size()), is_place(run.size());
  std::uint32_t added = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    for (; added < i && run[i].t_s - run[added].t_s > gap_s; ++added) index.add(added, run[added].descriptors);
    for (std::uint32_t j = 0; j < added; ++j) has_place[i] = has_place[i] || is_near(run[i], run[j], 1, 30);
    out.revisits += has_place[i];
    if (index.query(run[i].descriptors, {&best[i], 1}) == 0) continue;
    const auto within = [&](double m, double deg) {
      return best[i].id < n && is_near(run[i], run[best[i].id], m, deg);
    };
    is_place[i] = within(1, 30);
    if (!within(1, 30)) strict_threshold = std::max(strict_threshold, best[i].score);
    if (!within(2, 60)) out.threshold = std::max(out.threshold, best[i].score);
  }
  const double part = 1.0 / std::max(out.revisits, 1);
  for (std::uint32_t i = 0; i < n; ++i) {
    if (!is_place[i]) continue;
    out.first += part;
    if (best[i].score > strict_threshold) out.strict += part;
    if (best[i].score > out.threshold) out.recall += part;
  }
  return out;
}

}  // namespace plumbline::testing
