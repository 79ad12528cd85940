// The pose of a camera from points, lines and collinear points whose place is known, as at a relocalization: EPnP with
// rows of lines (LAP-SLAM) beside MSAC over P3P with Gauss-Newton (geometry/pose_ransac.hpp), by the same
// correspondences. Simulated ones, and those of recordings with ground truth. Prints tables in Markdown.
//
//   bench_opencv_line_assisted_pose [<directory of a recording> ...]
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "../../tests/geometry/line_assisted_epnp.hpp"
#include "plumbline/camera/any_camera.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/frontend/points_on_segments.hpp"
#include "plumbline/geometry/gravity_pose_ransac.hpp"
#include "plumbline/geometry/pose_ransac.hpp"
#include "plumbline/geometry/triangulation.hpp"
#include "plumbline/image/pyramid.hpp"
#include "plumbline/io/make_camera.hpp"
#include "plumbline/io/recording.hpp"
#include "plumbline/lie/interpolate.hpp"
#include "plumbline/opencv/image_file.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/testing/gaussian.hpp"
#include "plumbline/tracking/corner_detector.hpp"
#include "plumbline/tracking/edge_map.hpp"
#include "plumbline/tracking/line_segment_detector.hpp"
#include "plumbline/tracking/optical_flow.hpp"

namespace plumbline {
namespace {

using test::line_assisted_epnp;
using test::PointOnSegment;

using S = double;
using Points = FixedVector<PoseCorrespondence<S>, 400>;
using OnSegments = std::vector<PointOnSegment<S>>;

/// One frame to be found; what is known of the scene is in the axes of another camera.
struct Query {
  Points points;
  OnSegments lines, collinear;  ///< two rows for each line; one for each collinear point
  SE3<S> T_cam_world;           ///< true
  S depth = 1;                  ///< median of the points
};

// ---------------------------------------------------------------------------------------------------------- methods

enum Rows { points_alone, with_collinear, with_lines, with_both };
constexpr std::array<const char*, 4> row_names{"points", "points, collinear", "points, lines",
                                               "points, lines, collinear"};
constexpr S chi2 = 5.991;

OnSegments rows_of(const Query& query, Rows rows) {
  OnSegments out;
  if (rows == with_lines || rows == with_both) out = query.lines;
  if (rows == with_collinear || rows == with_both)
    out.insert(out.end(), query.collinear.begin(), query.collinear.end());
  return out;
}
S error2(const SE3<S>& T, const PointOnSegment<S>& row) {
  const Vec<S, 3> p = T * row.p_world;
  const S e = dot(row.normal, p) / (norm(p) * row.sigma_rad);
  return e * e;
}

/// What agrees with a pose.
struct Inliers {
  std::vector<PoseCorrespondence<S>> points;
  OnSegments on_segments;

  Inliers(const Query& query, const SE3<S>& T, const OnSegments& rows) {
    for (const auto& c : query.points) {
      const Vec<S, 3> p = T * c.p_world;
      if (squared_norm(Vec<S, 3>(normalized(p) - c.bearing)) < chi2 * c.sigma_rad * c.sigma_rad) points.push_back(c);
    }
    for (const auto& row : rows)
      if (error2(T, row) < chi2) on_segments.push_back(row);
  }
};

/// Gauss-Newton on all rows, by their angles, with the weights of pose_ransac at its gate.
SE3<S> refine(SE3<S> T, const Query& query, const OnSegments& rows) {
  for (const S widening : {S(16), S(4), S(1), S(1), S(1)}) {
    const auto weight = [gate = widening * chi2](S e2) { return gate * gate / ((gate + e2) * (gate + e2)); };
    DenseNormalEquations<S, 6> equations;
    const Mat<S, 3, 3> R = T.R();
    for (const auto& c : query.points) {
      const BearingError<S> error(T, R, c);
      const S information = 1 / (c.sigma_rad * c.sigma_rad), w = weight(information * squared_norm(error.r));
      if (w > 0) equations.add(error.J_r_T, error.r, information * w);
    }
    for (const auto& row : rows) {
      // n . b of the predicted bearing b; the bearing error's Jacobian is that of b
      const BearingError<S> predicted(T, R, {Vec<S, 3>(0, 0, 0), row.p_world, row.sigma_rad});
      const S w = weight(error2(T, row)) / (row.sigma_rad * row.sigma_rad);
      if (w > 0)
        equations.add(Mat<S, 1, 6>(row.normal.transpose() * predicted.J_r_T), Vec<S, 1>(dot(row.normal, predicted.r)),
                      w);
    }
    Vec<S, 6> d;
    if (!equations.solve(d)) break;
    T = plus(T, d);
  }
  return T;
}

PoseRansacResult<S, 400> by_p3p(const Query& query) {
  return ransac_pose(query.points, SE3<S>(SO3<S>(), Vec<S, 3>(0, 0, -1e3)),
                     {.max_iterations = 200, .confidence = 0.999});
}
/// The same with samples of two points, where the z axis of the world is known in the camera to 0.01 rad.
PoseRansacResult<S, 400> by_gravity(const Query& query) {
  const Vec<S, 3> up = SO3<S>::exp({0.008, -0.006, 0}) * (query.T_cam_world.rotation() * Vec<S, 3>(0, 0, 1));
  return ransac_gravity_pose(query.points, up, SE3<S>(SO3<S>(), Vec<S, 3>(0, 0, -1e3)),
                             {.max_iterations = 200, .confidence = 0.999});
}
/// The same search with samples of six points for EPnP.
PoseRansacResult<S, 400> by_epnp(const Query& query) {
  const auto draw = [&](Random& random, auto&& offer) {
    std::array<PoseCorrespondence<S>, 6> sample;
    for (auto& c : sample) c = query.points[random.below(std::uint32_t(query.points.size()))];
    const auto pose = line_assisted_epnp<S>(sample, {});
    if (pose.valid) offer(pose.T_cam_world);
  };
  return pose_ransac_detail::search<6>(
      query.points, SE3<S>(SO3<S>(), Vec<S, 3>(0, 0, -1e3)), {.max_iterations = 200, .confidence = 0.999},
      [](const SE3<S>&) { return true; }, draw);
}

// ---------------------------------------------------------------------------------------------------------- figures

struct Tally {
  std::vector<double> position, rotation_deg, time_us;
  int asked = 0, near = 0;

  void add(const Query& query, bool valid, const SE3<S>& T, double us) {
    ++asked;
    time_us.push_back(us);
    const Vec<S, 6> e = minus(T, query.T_cam_world);
    const double apart = (T.inverse().p() - query.T_cam_world.inverse().p()).norm() / query.depth;
    if (!valid || !(apart < 0.1)) return;
    near += apart < 0.01;
    position.push_back(100 * apart);
    rotation_deg.push_back(norm(Vec<S, 3>(segment<3>(e, 0))) * 57.29577951308232);
  }
  void print(const char* method, const char* rows) {
    const auto rmse = [](const std::vector<double>& x) {
      double sum = 0;
      for (const double e : x) sum += e * e;
      return std::sqrt(sum / double(x.size()));
    };
    std::nth_element(time_us.begin(), time_us.begin() + std::ptrdiff_t(time_us.size() / 2), time_us.end());
    std::printf("| %s | %s | %.3f %% | %.3f %% | %.4f deg | %.1f %% | %.0f us |\n", method, rows, rmse(position),
                position.empty() ? 0 : *std::max_element(position.begin(), position.end()), rmse(rotation_deg),
                100.0 * near / asked, time_us[time_us.size() / 2]);
  }
};

double us_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count();
}

void report(const char* name, const std::vector<Query>& queries) {
  std::size_t points = 0, lines = 0, collinear = 0;
  for (const Query& query : queries) {
    points += query.points.size();
    lines += query.lines.size() / 2;
    collinear += query.collinear.size();
  }
  const double n = double(queries.size());
  std::printf("\n%s: %zu frames; points %.0f, lines %.1f, collinear points %.1f a frame\n\n", name, queries.size(),
              double(points) / n, double(lines) / n, double(collinear) / n);
  if (queries.empty()) return;
  std::printf(
      "| method | rows | RMSE | maximum | rotation | within 1 %% | time |\n| --- | --- | --- | --- | --- | --- | --- "
      "|\n");
  Tally p3p, gravity, epnp;
  std::array<Tally, 4> linear, from_p3p, from_linear;
  for (const Query& query : queries) {
    auto begin = std::chrono::steady_clock::now();
    const auto found = by_p3p(query);
    p3p.add(query, found.valid, found.T_cam_world, us_since(begin));
    begin = std::chrono::steady_clock::now();
    const auto found_by_gravity = by_gravity(query);
    gravity.add(query, found_by_gravity.valid, found_by_gravity.T_cam_world, us_since(begin));
    begin = std::chrono::steady_clock::now();
    const auto found_by_epnp = by_epnp(query);
    epnp.add(query, found_by_epnp.valid, found_by_epnp.T_cam_world, us_since(begin));
    for (const Rows rows : {points_alone, with_collinear, with_lines, with_both}) {
      const OnSegments on_segments = rows_of(query, rows);
      begin = std::chrono::steady_clock::now();
      const Inliers inliers(query, found.T_cam_world, on_segments);
      const auto pose = line_assisted_epnp<S>(inliers.points, inliers.on_segments);
      const double us = us_since(begin);
      linear[rows].add(query, found.valid && pose.valid, pose.T_cam_world, us);
      begin = std::chrono::steady_clock::now();
      const SE3<S> refined = refine(found.T_cam_world, query, on_segments);
      from_p3p[rows].add(query, found.valid, refined, us_since(begin));
      begin = std::chrono::steady_clock::now();
      const SE3<S> polished = refine(pose.T_cam_world, query, on_segments);
      from_linear[rows].add(query, found.valid && pose.valid, polished, us + us_since(begin));
    }
  }
  p3p.print("MSAC, P3P", "points");
  gravity.print("MSAC, two points and the vertical", "points");
  epnp.print("MSAC, EPnP of six points", "points");
  for (int rows = 0; rows < 4; ++rows)
    linear[std::size_t(rows)].print("EPnP of the inliers", row_names[std::size_t(rows)]);
  for (int rows = 0; rows < 4; ++rows)
    from_p3p[std::size_t(rows)].print("Gauss-Newton from P3P", row_names[std::size_t(rows)]);
  for (int rows = 0; rows < 4; ++rows)
    from_linear[std::size_t(rows)].print("Gauss-Newton from EPnP", row_names[std::size_t(rows)]);
  std::fflush(stdout);
}

// -------------------------------------------------------------------------------------------------------- simulation

/// `outliers`: their share among points. One pixel is 1/500 rad; places in space are known to 1 % of their range.
std::vector<Query> simulate(int frames, int points, int lines, double outliers) {
  Random random(7);
  testing::Gaussian gaussian(8);
  constexpr double sigma = 1.0 / 500, of_range = 0.01;
  const auto symmetric = [&] { return 2 * random.uniform() - 1; };
  std::vector<Query> out;
  for (int f = 0; f < frames; ++f) {
    Query query;
    Vec<S, 6> xi;
    for (int i = 0; i < 6; ++i) xi[i] = 0.5 * symmetric();
    query.T_cam_world = SE3<S>::exp(xi);
    query.depth = 4;
    const auto place = [&]() -> Vec<S, 3> {
      const double z = 1 + 6 * random.uniform();
      return query.T_cam_world.inverse() * Vec<S, 3>(0.8 * z * symmetric(), 0.6 * z * symmetric(), z);
    };
    const auto seen = [&](const Vec<S, 3>& p) -> Vec<S, 3> {
      const Vec<S, 3> b = normalized(Vec<S, 3>(query.T_cam_world * p)), e(gaussian(), gaussian(), gaussian());
      return normalized(Vec<S, 3>(b + sigma * (e - dot(b, e) * b)));
    };
    const auto known = [&](const Vec<S, 3>& p) -> Vec<S, 3> { return (1 + of_range * gaussian()) * p; };
    const auto add = [&](const Vec<S, 3>& p) {
      Vec<S, 3> b = seen(p);
      if (random.uniform() < outliers) b = normalized(Vec<S, 3>(0.8 * symmetric(), 0.6 * symmetric(), 1));
      const Vec<S, 3> where = known(p);
      query.points.push_back({b, where, sigma});
      return where;
    };
    for (int i = 0; i < points; ++i) add(place());
    for (int i = 0; i < lines; ++i) {
      const Vec<S, 3> p = place(), q = place(), normal = normalized(Vec<S, 3>(seen(p).cross(seen(q))));
      query.lines.push_back({normal, known(p), sigma});
      query.lines.push_back({normal, known(q), sigma});
      for (const double along : {0.2, 0.5, 0.8}) query.collinear.push_back({normal, add(p + along * (q - p)), sigma});
    }
    out.push_back(std::move(query));
  }
  return out;
}

// -------------------------------------------------------------------------------------------------------- recordings

constexpr std::size_t max_pixels = 752 * 480;
constexpr int located_after = 15;                              // views of the map, where depth is not measured
constexpr std::array<int, 5> asked_after{20, 25, 30, 35, 40};  // frames after the keyframe
constexpr int keyframe_every = 15;
constexpr float member_px = 4, separation_px = 10;  // CollinearOptions
constexpr double sigma_px = 1;
using Pyr = Pyramid<4, max_pixels>;
using Segments = FixedVector<LineSegment, 300>;

struct Track {
  struct Seen {
    bool valid;
    Vec<float, 2> pixel;
  };
  std::uint32_t id;
  Seen current;
  Vec<S, 3> bearing;  ///< in the keyframe
  S range = 0;        ///< 0: not known
  std::vector<TriangulationView<S>> views;
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
using Association = PointsOnSegments<Members>;

/// A line of the keyframe: members, and two points in space.
struct KnownLine {
  Members members;
  std::array<Vec<S, 3>, 2> ends;
};

class Pictures {
 public:
  explicit Pictures(const char* directory)
      : recording_(io::Recording::open(directory)),
        truth_(recording_.read_groundtruth(false).value()),
        camera_(io::make_camera<S>(recording_.calibration().camera)),
        px_per_rad_(recording_.calibration().camera.intrinsics[0]) {
    for (const io::FrameSample& sample : recording_.frames()) {
      gray_.push_back(opencv::read_gray(sample.image));
      depth_.push_back(recording_.has_depth() && sample.depth ? opencv::read_depth(*sample.depth) : cv::Mat());
    }
  }

  std::vector<Query> queries() {
    std::vector<Query> out;
    for (int k = 0; k + asked_after.back() < int(gray_.size()); k += keyframe_every) ask_after(k, out);
    return out;
  }

 private:
  std::optional<SE3<S>> pose(int frame) const {
    const TimeNs t = recording_.frames()[std::size_t(frame)].t_ns;
    const auto after = std::lower_bound(truth_.begin(), truth_.end(), t,
                                        [](const io::StampedPose& pose, TimeNs time) { return pose.t_ns < time; });
    if (after == truth_.end() || (after == truth_.begin() && after->t_ns != t)) return std::nullopt;
    if (after->t_ns == t) return after->T_world_body;
    const auto before = after - 1;
    if (after->t_ns - before->t_ns > 50'000'000) return std::nullopt;
    const double part = double(t - before->t_ns) / double(after->t_ns - before->t_ns);
    return interpolate(before->T_world_body, after->T_world_body, part).T;
  }
  Vec<S, 3> bearing(const Vec<float, 2>& uv) const { return camera_.unproject(cast_to<S>(uv)).bearing; }
  void detect(int frame, Segments& out) {
    const auto image = opencv::view<std::uint8_t>(gray_[std::size_t(frame)]);
    out.clear();
    if (edges_->compute(image, LineDetectorOptions{}.min_gradient))
      detector_->detect(image, *edges_, LineDetectorOptions{}, out);
  }

  /// A keyframe's corners, followed from frame to frame; frames after it ask for their pose.
  void ask_after(int keyframe, std::vector<Query>& out) {
    const auto T_world_key = pose(keyframe);
    if (!T_world_key) return;
    Tracks tracks;
    FixedVector<Corner, 400> corners;
    CornerOptions options;
    options.cell_px = 20;
    pyramids_[0]->build(opencv::view<std::uint8_t>(gray_[std::size_t(keyframe)]));
    detect_corners(pyramids_[0]->level(0), nullptr, 0, options, corners);
    for (std::uint32_t id = 0; id < corners.size(); ++id)
      tracks.list.push_back({id, {true, corners[id].uv}, bearing(corners[id].uv), 0, {}});
    Segments segments;
    detect(keyframe, segments);
    const Tracks at_keyframe = tracks;
    measure_depth(keyframe, tracks);
    std::vector<KnownLine> lines;
    for (int i = 1; i <= asked_after.back(); ++i) {
      Pyr &before = *pyramids_[std::size_t((i + 1) % 2)], &now = *pyramids_[std::size_t(i % 2)];
      now.build(opencv::view<std::uint8_t>(gray_[std::size_t(keyframe + i)]));
      const auto T_world_cam = pose(keyframe + i);
      if (!T_world_cam) return;
      const SE3<S> T_cam_key = T_world_cam->inverse() * *T_world_key;
      for (Track& track : tracks.list) {
        if (!track.current.valid) continue;
        const FlowResult flow = track_point_checked(before, now, track.current.pixel, track.current.pixel, {});
        track.current = {flow.valid, flow.uv};
        if (flow.valid && i <= located_after)
          track.views.push_back({T_cam_key, bearing(flow.uv), sigma_px / px_per_rad_});
      }
      if (i == located_after) {
        triangulate_tracks(tracks);
        lines = known_lines(tracks, at_keyframe, segments);
      }
      if (std::find(asked_after.begin(), asked_after.end(), i) != asked_after.end())
        add_query(keyframe + i, T_cam_key, tracks, lines, out);
    }
  }
  void measure_depth(int keyframe, Tracks& tracks) const {
    const cv::Mat& depth = depth_[std::size_t(keyframe)];
    if (depth.empty()) return;
    for (Track& track : tracks.list) {
      const int u = int(track.current.pixel.x() + 0.5f), v = int(track.current.pixel.y() + 0.5f);
      if (u < 0 || v < 0 || u >= depth.cols || v >= depth.rows) continue;
      const S z = S(depth.at<std::uint16_t>(v, u)) / recording_.calibration().depth_scale;
      if (z > 0) track.range = z / track.bearing.z();
    }
  }
  void triangulate_tracks(Tracks& tracks) const {
    if (recording_.has_depth()) return;
    for (Track& track : tracks.list) {
      const auto found = triangulate<S>(track.bearing, track.views);
      if (found.valid && std::sqrt(found.variance) < 0.1 * found.inverse_range) track.range = 1 / found.inverse_range;
    }
  }
  /// Located by the members, whose inverse ranges are affine along the segment's image when divided by the cosine: by
  /// least squares, and by members alone that agree within 5 %.
  std::vector<KnownLine> known_lines(const Tracks& tracks, const Tracks& at_keyframe, const Segments& segments) {
    std::vector<KnownLine> out;
    association_->associate(at_keyframe, segments, member_px);
    for (std::size_t k = 0; k < segments.size(); ++k) {
      KnownLine line;
      struct Located {
        Member member;
        S along, inverse_depth;
      };
      std::vector<Located> located;
      for (const Member& member : association_->of(k, at_keyframe)) {
        const Track& track = tracks.list[std::size_t(member.hint)];
        if (!(track.range > 0) || !(track.bearing.z() > 0.2)) continue;
        const Vec<float, 2> uv = at_keyframe.list[std::size_t(member.hint)].current.pixel;
        located.push_back(
            {member, S(segments[k].direction().dot(uv - segments[k].start)), 1 / (track.range * track.bearing.z())});
      }
      while (located.size() >= 2) {
        S n = 0, x = 0, y = 0, xx = 0, xy = 0;
        for (const Located& one : located) {
          ++n;
          x += one.along, y += one.inverse_depth, xx += one.along * one.along, xy += one.along * one.inverse_depth;
        }
        const S slope = (n * xy - x * y) / (n * xx - x * x), offset = (y - slope * x) / n;
        const auto misfit = [&](const Located& one) {
          return std::abs((offset + slope * one.along) / one.inverse_depth - 1);
        };
        const auto order = [&](const Located& a, const Located& b) { return misfit(a) < misfit(b); };
        const auto worst = std::max_element(located.begin(), located.end(), order);
        if (!(misfit(*worst) < 0.05)) {
          located.erase(worst);
          continue;
        }
        const auto [first, last] = std::minmax_element(
            located.begin(), located.end(), [](const Located& a, const Located& b) { return a.along < b.along; });
        if (!(last->along - first->along > separation_px)) break;
        for (const Located& one : located)
          if (!line.members.full()) line.members.push_back(one.member);
        for (const int end : {0, 1}) {
          const S along = end == 0 ? first->along : last->along;
          const Vec<S, 3> b = bearing(segments[k].start + float(along) * segments[k].direction());
          line.ends[std::size_t(end)] = b / (b.z() * (offset + slope * along));
        }
        out.push_back(line);
        break;
      }
    }
    return out;
  }
  void add_query(int frame, const SE3<S>& T_cam_key, const Tracks& tracks, const std::vector<KnownLine>& lines,
                 std::vector<Query>& out) {
    Query query;
    query.T_cam_world = T_cam_key;
    std::vector<S> depths;
    for (const Track& track : tracks.list) {
      if (!track.current.valid || !(track.range > 0)) continue;
      query.points.push_back({bearing(track.current.pixel), track.range * track.bearing, S(sigma_px / px_per_rad_)});
      depths.push_back(track.range);
    }
    if (query.points.size() < 20) return;
    std::nth_element(depths.begin(), depths.begin() + std::ptrdiff_t(depths.size() / 2), depths.end());
    query.depth = depths[depths.size() / 2];
    Segments segments;
    detect(frame, segments);
    association_->associate(tracks, segments, member_px);
    for (const KnownLine& line : lines) {
      std::size_t most = 0, best = 0;
      for (std::size_t k = 0; k < segments.size(); ++k) {
        const Members shared = shared_of(line.members, association_->of(k, tracks));
        if (shared.size() < 2 || shared.size() <= most || !are_apart(shared, tracks)) continue;
        most = shared.size();
        best = k;
      }
      if (most == 0) continue;
      const LineSegment& segment = segments[best];
      const Vec<S, 3> normal = normalized(Vec<S, 3>(bearing(segment.start).cross(bearing(segment.end))));
      for (const Vec<S, 3>& end : line.ends) query.lines.push_back({normal, end, sigma_px / px_per_rad_});
      for (const Member& member : shared_of(line.members, association_->of(best, tracks))) {
        const Track& track = tracks.list[std::size_t(member.hint)];
        const S offset_px = std::abs(S(segment.distance(track.current.pixel)));
        query.collinear.push_back({normal, track.range * track.bearing,
                                   std::sqrt(sigma_px * sigma_px + offset_px * offset_px) / px_per_rad_});
      }
    }
    out.push_back(std::move(query));
  }
  static Members shared_of(const Members& a, const Members& b) {
    Members out;
    for (const Member& member : a)
      if (std::any_of(b.begin(), b.end(), [&](const Member& other) { return other.id == member.id; }))
        out.push_back(member);
    return out;
  }
  static bool are_apart(const Members& members, const Tracks& tracks) {
    for (const Member& a : members)
      for (const Member& b : members)
        if (norm(Vec<float, 2>(tracks.list[std::size_t(a.hint)].current.pixel -
                               tracks.list[std::size_t(b.hint)].current.pixel)) > separation_px)
          return true;
    return false;
  }

  io::Recording recording_;
  io::Trajectory truth_;
  AnyCamera<S> camera_;
  S px_per_rad_;
  std::vector<cv::Mat> gray_, depth_;
  std::array<std::unique_ptr<Pyr>, 2> pyramids_{std::make_unique<Pyr>(), std::make_unique<Pyr>()};
  std::unique_ptr<EdgeMap<max_pixels>> edges_ = std::make_unique<EdgeMap<max_pixels>>();
  std::unique_ptr<LineSegmentDetector<>> detector_ = std::make_unique<LineSegmentDetector<>>();
  std::unique_ptr<Association> association_ = std::make_unique<Association>();
};

}  // namespace
}  // namespace plumbline

int main(int argc, char** argv) try {
  namespace pl = plumbline;
  pl::report("simulated, 60 points, 10 lines, no outliers", pl::simulate(500, 30, 10, 0));
  pl::report("simulated, 60 points, 10 lines, 30 % outliers", pl::simulate(500, 30, 10, 0.3));
  pl::report("simulated, 15 points, 3 lines, no outliers", pl::simulate(500, 6, 3, 0));
  for (int k = 1; k < argc; ++k)
    pl::report(std::filesystem::path(argv[k]).filename().string().c_str(), pl::Pictures(argv[k]).queries());
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
