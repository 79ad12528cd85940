// Segments of two images paired by the points that they share (docs/math/collinear.md), and by LBD, on rendered pairs
// whose depth tells which pairs are right. Counters are means of a pair of images: matches, share of right ones in
// percent, and pairs of segments that show one edge.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

#include "plumbline/camera/pinhole.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/frontend/points_on_segments.hpp"
#include "plumbline/image/pyramid.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/testing/gaussian.hpp"
#include "plumbline/testing/renderer.hpp"
#include "plumbline/testing/rig.hpp"
#include "plumbline/testing/scenes.hpp"
#include "plumbline/testing/simulated_camera.hpp"
#include "plumbline/testing/trajectory.hpp"
#include "plumbline/tracking/corner_detector.hpp"
#include "plumbline/tracking/edge_map.hpp"
#include "plumbline/tracking/line_segment_detector.hpp"
#include "plumbline/tracking/optical_flow.hpp"
#ifdef PLUMBLINE_LBD
#include "plumbline/opencv/lbd_matching.hpp"
#endif

namespace plumbline {
namespace {

constexpr int width = 640, height = 480;
constexpr float member_px = 4, separation_px = 10;  // CollinearOptions
const Pinhole<double> camera{500, 500, 319.5, 239.5, {}};
using Segments = FixedVector<LineSegment, 300>;
using Pyr = Pyramid<4, std::size_t(width* height)>;

struct PairOfSegments {
  std::size_t first, second;
};

/// A point of the first view that was tracked to the second.
struct Track {
  struct Seen {
    bool valid;
    Vec<float, 2> pixel;
  };
  std::uint32_t id;
  Seen current;
};
struct Tracks {
  std::vector<Track> list;
  const std::vector<Track>& landmarks() const { return list; }
};
struct Member {
  std::uint32_t id;
  int hint;
};
using Members = FixedVector<Member, 32>;

struct ViewOfScene {
  SE3<double> T_world_cam;
  cv::Mat gray;
  testing::Image<float> depth{width, height};
  Segments segments;
  Tracks tracks;
};

void observe(testing::Renderer& renderer, const SE3<double>& T_world_body, std::uint64_t seed, ViewOfScene& out) {
  out.T_world_cam = T_world_body * testing::simulated_T_body_camera();
  testing::Image<float> gray(width, height);
  renderer.render(out.T_world_cam, gray.view(), out.depth.view());
  testing::Gaussian noise(seed);
  cv::Mat image(height, width, CV_32F, const_cast<float*>(gray.pixels().data()));
  cv::GaussianBlur(image, image, {5, 5}, 0.6);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) image.at<float>(v, u) += float(1.5 * noise());
  image.convertTo(out.gray, CV_8U);
  static const auto edges = std::make_unique<EdgeMap<std::size_t(width * height)>>();
  static const auto detector = std::make_unique<LineSegmentDetector<>>();
  if (edges->compute(opencv::view<std::uint8_t>(out.gray), LineDetectorOptions{}.min_gradient))
    detector->detect(opencv::view<std::uint8_t>(out.gray), *edges, LineDetectorOptions{}, out.segments);
}

struct ViewPair {
  ViewOfScene first, second;

  /// Corners of the first view, one a cell, tracked as odometry does.
  void track(int cell_px) {
    const auto before = std::make_unique<Pyr>(), after = std::make_unique<Pyr>();
    before->build(opencv::view<std::uint8_t>(first.gray));
    after->build(opencv::view<std::uint8_t>(second.gray));
    FixedVector<Corner, 1000> corners;
    CornerOptions options;
    options.cell_px = cell_px;
    detect_corners(before->level(0), nullptr, 0, options, corners);
    for (std::uint32_t id = 0; id < corners.size(); ++id) {
      const FlowResult flow = track_point_checked(*before, *after, corners[id].uv, corners[id].uv, {});
      first.tracks.list.push_back({id, {flow.valid, corners[id].uv}});
      second.tracks.list.push_back({id, {flow.valid, flow.uv}});
    }
  }
};

std::vector<std::unique_ptr<ViewPair>> make_pairs(int cell_px) {
  std::vector<std::unique_ptr<ViewPair>> out;
  for (const char* scene : {"room", "boards", "hall", "corridor", "walk"}) {
    constexpr std::uint64_t seed = 11;
    testing::Renderer renderer(*testing::make_scene(scene, seed), camera, width, height, 2);
    const testing::Trajectory trajectory = *testing::Trajectory::for_scene(scene, seed);
    for (int k = 0; k < 6; ++k) {
      const double t = 2 + 2.3 * k, after_s = 0.2;
      auto pair = std::make_unique<ViewPair>();
      observe(renderer, trajectory.at(t).T_world_body, 2 * out.size(), pair->first);
      observe(renderer, trajectory.at(t + after_s).T_world_body, 2 * out.size() + 1, pair->second);
      pair->track(cell_px);
      out.push_back(std::move(pair));
    }
  }
  return out;
}

// ------------------------------------------------------------------------------------------------- what is right

/// Part of segment `a` of one view that lies on segment `b` of another; an edge belongs to the nearest surface at it.
double share_on(const ViewOfScene& from, const LineSegment& a, const ViewOfScene& to, const LineSegment& b) {
  constexpr int samples = 20;
  const ImageView<const float> depth = from.depth.view();
  int hits = 0;
  for (int k = 0; k < samples; ++k) {
    const Vec<float, 2> at = a.start + (float(k) + 0.5f) / samples * (a.end - a.start);
    float z = 1e3f;
    for (const float j : {-2.0f, 0.0f, 2.0f}) {
      const Vec<float, 2> uv = at + j * a.normal();
      if (!depth.contains(uv.x(), uv.y(), 1.0f)) continue;
      const float here = depth(int(uv.x() + 0.5f), int(uv.y() + 0.5f));
      if (here > 0) z = std::min(z, here);
    }
    const Vec<double, 3> bearing = camera.unproject(Vec<double, 2>(at.cast<double>())).bearing;
    const Vec<double, 3> p_world = from.T_world_cam * Vec<double, 3>(double(z) / bearing.z() * bearing);
    const auto seen = camera.project(to.T_world_cam.inverse() * p_world);
    if (!seen.valid) continue;
    const Vec<float, 2> uv = seen.uv.cast<float>();
    const float along = b.direction().dot(uv - b.start);
    hits += std::abs(b.distance(uv)) < 2.5f && along > -5 && along < b.length() + 5;
  }
  return double(hits) / samples;
}
bool is_right(const ViewPair& pair, std::size_t i, std::size_t j) {
  const LineSegment &a = pair.first.segments[i], &b = pair.second.segments[j];
  return a.direction().dot(b.direction()) > 0.8f &&
         std::max(share_on(pair.first, a, pair.second, b), share_on(pair.second, b, pair.first, a)) > 0.5;
}

// -------------------------------------------------------------------------------------------------------- matching

bool are_apart(const Members& shared, const Tracks& first, const Tracks& second) {
  for (const Member& a : shared) {
    for (const Member& b : shared) {
      const auto distance = [&](const Tracks& tracks) {
        return norm(Vec<float, 2>(tracks.list[std::size_t(a.hint)].current.pixel -
                                  tracks.list[std::size_t(b.hint)].current.pixel));
      };
      if (distance(first) > separation_px && distance(second) > separation_px) return true;
    }
  }
  return false;
}

/// Segments that share two points or more, those with the most first; each is in one pair at most.
std::vector<PairOfSegments> match_by_points(const ViewPair& pair) {
  static PointsOnSegments<Members> on_first, on_second;
  const Segments &first = pair.first.segments, &second = pair.second.segments;
  on_first.associate(pair.first.tracks, first, member_px);
  on_second.associate(pair.second.tracks, second, member_px);
  struct Candidate {
    PairOfSegments pair;
    std::size_t shared;
  };
  std::vector<Members> of_second;
  for (std::size_t j = 0; j < second.size(); ++j) of_second.push_back(on_second.of(j, pair.second.tracks));
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const Members members = on_first.of(i, pair.first.tracks);
    if (members.size() < 2) continue;
    for (std::size_t j = 0; j < second.size(); ++j) {
      Members shared;
      for (const Member& a : members) {
        if (std::any_of(of_second[j].begin(), of_second[j].end(), [&](const Member& b) { return b.id == a.id; }))
          shared.push_back(a);
      }
      if (shared.size() < 2 || !are_apart(shared, pair.first.tracks, pair.second.tracks)) continue;
      if (!(first[i].direction().dot(second[j].direction()) > 0)) continue;
      candidates.push_back({{i, j}, shared.size()});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.shared > b.shared; });
  std::vector<bool> first_used(first.size()), second_used(second.size());
  std::vector<PairOfSegments> out;
  for (const Candidate& candidate : candidates) {
    const auto [i, j] = candidate.pair;
    if (first_used[i] || second_used[j]) continue;
    first_used[i] = second_used[j] = true;
    out.push_back({i, j});
  }
  return out;
}

#ifdef PLUMBLINE_LBD
std::vector<PairOfSegments> match_by_lbd(const ViewPair& pair) {
  std::vector<PairOfSegments> out;
  const auto matches = opencv::match_lines_lbd(opencv::view<std::uint8_t>(pair.first.gray), pair.first.segments,
                                               opencv::view<std::uint8_t>(pair.second.gray), pair.second.segments);
  for (const opencv::LineMatch& match : matches) out.push_back({match.first, match.second});
  return out;
}
#endif

/// Of all pairs of views, one after the other.
template <class Match>
void match_segments(benchmark::State& state, int cell_px, const Match& match) {
  cv::setNumThreads(1);
  const auto pairs = make_pairs(cell_px);
  for (auto _ : state) {
    for (const auto& pair : pairs) benchmark::DoNotOptimize(match(*pair));
  }
  double matches = 0, right = 0, possible = 0, tracked = 0;
  for (const auto& pair : pairs) {
    for (const Track& track : pair->first.tracks.list) tracked += track.current.valid;
    for (const PairOfSegments& one : match(*pair)) {
      ++matches;
      right += is_right(*pair, one.first, one.second);
    }
    for (std::size_t i = 0; i < pair->first.segments.size(); ++i) {
      bool is_seen = false;
      for (std::size_t j = 0; j < pair->second.segments.size() && !is_seen; ++j) is_seen = is_right(*pair, i, j);
      possible += is_seen;
    }
  }
  const double n = double(pairs.size());
  state.counters["pairs"] = n;
  state.counters["points"] = tracked / n;
  state.counters["matches"] = matches / n;
  state.counters["right_percent"] = 100 * right / matches;
  state.counters["possible"] = possible / n;
  state.counters["s_a_pair"] =
      benchmark::Counter(n, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
void by_shared_points(benchmark::State& state) { match_segments(state, int(state.range(0)), match_by_points); }
BENCHMARK(by_shared_points)->ArgName("cell_px")->Arg(32)->Arg(20)->Unit(benchmark::kMillisecond);
#ifdef PLUMBLINE_LBD
void by_lbd(benchmark::State& state) { match_segments(state, 32, match_by_lbd); }
BENCHMARK(by_lbd)->Unit(benchmark::kMillisecond);
#endif

}  // namespace
}  // namespace plumbline

BENCHMARK_MAIN();
