#include "covisibility.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "plumbline/tracking/binary_descriptor.hpp"

namespace io = plumbline::io;
namespace pl = plumbline;

namespace {

constexpr std::size_t least_features = 15, most_neighbors = 4;
constexpr double max_distance = 0.01;  // from a feature, in the image plane at unit distance
constexpr int max_hamming = 50;        // [bits] of 256

struct LocatedFeature {
  pl::Vec<double, 3> p_map;
  const pl::PlaceFeature* feature;
};
struct SeenFeature {
  double u, v;  // in the image plane at unit distance
  const pl::PlaceFeature* feature;
};

std::vector<LocatedFeature> located_features(const io::MapContents::Keyframe& entry) {
  std::vector<LocatedFeature> out;
  entry.for_each_point([&](const pl::PlaceFeature& feature, const pl::Vec<double, 3>& p, double) {
    out.push_back({p, &feature});
  });
  return out;
}

/// Ordered by u; what is not in front of the camera is left out.
std::vector<SeenFeature> seen_features(const io::MapContents::Keyframe& entry) {
  std::vector<SeenFeature> out;
  for (const pl::PlaceFeature& feature : entry.features) {
    const pl::Vec<double, 3> bearing = pl::cast_to<double>(feature.bearing);
    if (bearing.z() > 0.1) out.push_back({bearing.x() / bearing.z(), bearing.y() / bearing.z(), &feature});
  }
  std::sort(out.begin(), out.end(), [](const SeenFeature& a, const SeenFeature& b) { return a.u < b.u; });
  return out;
}

std::size_t common_features(const std::vector<LocatedFeature>& points, const pl::ArchivedKeyframe& camera,
                            const std::vector<SeenFeature>& places) {
  const pl::Sim3<double> S_cam_map = pl::Sim3<double>(camera.T_body_cam.inverse()) * camera.S_map_body.inverse();
  std::size_t out = 0;
  for (const LocatedFeature& point : points) {
    const pl::Vec<double, 3> p = S_cam_map * point.p_map;
    if (!(p.z() > 0.1 * p.norm())) continue;
    const double u = p.x() / p.z(), v = p.y() / p.z();
    auto place = std::lower_bound(places.begin(), places.end(), u - max_distance,
                                  [](const SeenFeature& each, double least) { return each.u < least; });
    for (; place != places.end() && place->u <= u + max_distance; ++place) {
      if (std::abs(place->v - v) > max_distance ||
          pl::hamming_distance(place->feature->descriptor, point.feature->descriptor) > max_hamming)
        continue;
      ++out;
      break;
    }
  }
  return out;
}

}  // namespace

std::vector<Covisibility> covisible_keyframes(const io::MapContents& map) {
  const std::size_t n = map.keyframes.size();
  std::vector<std::vector<SeenFeature>> places;
  for (const auto& entry : map.keyframes) places.push_back(seen_features(entry));
  std::vector<std::vector<Covisibility>> neighbors(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::vector<LocatedFeature> points = located_features(map.keyframes[i]);
    for (std::size_t j = i + 1; j < n; ++j) {
      const std::size_t features = common_features(points, map.keyframes[j].keyframe, places[j]);
      if (features < least_features) continue;
      neighbors[i].push_back({i, j, features});
      neighbors[j].push_back({i, j, features});
    }
  }
  std::vector<Covisibility> out;
  std::set<std::pair<std::size_t, std::size_t>> taken;
  for (std::vector<Covisibility>& each : neighbors) {
    std::stable_sort(each.begin(), each.end(),
                     [](const Covisibility& a, const Covisibility& b) { return a.features > b.features; });
    each.resize(std::min(each.size(), most_neighbors));
    for (const Covisibility& pair : each)
      if (taken.insert({pair.i, pair.j}).second) out.push_back(pair);
  }
  std::sort(out.begin(), out.end(),
            [](const Covisibility& a, const Covisibility& b) { return std::pair(a.i, a.j) < std::pair(b.i, b.j); });
  return out;
}
