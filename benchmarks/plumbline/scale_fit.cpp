#include "scale_fit.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <Eigen/Cholesky>

#include "plumbline/geometry/relative_pose.hpp"
#include "statistics.hpp"

namespace pl = plumbline;

namespace {

using Vector3 = pl::Vec<double, 3>;
using SO3 = pl::SO3<double>;
using SE3 = pl::SE3<double>;
using Points = std::map<std::uint32_t, Vector3>;  // by corner, in the camera of the first frame

constexpr std::size_t least_points = 12;

/// Rotation and twice integrated specific force since the begin of a window, in the axes of the IMU there.
struct ImuMotion {
  double t_s = 0;
  SO3 R;
  Vector3 velocity = Vector3::Zero(), position = Vector3::Zero();
};

/// At the given times, in order; nothing where the samples do not cover them.
std::vector<ImuMotion> integrate(const std::vector<pl::ImuSample>& samples, const std::vector<pl::TimeNs>& times,
                                 const Vector3& gyro_bias) {
  std::vector<ImuMotion> out;
  auto next = std::upper_bound(samples.begin(), samples.end(), times.front(),
                               [](pl::TimeNs t, const pl::ImuSample& s) { return t < s.t_ns; });
  if (next == samples.begin() || times.back() > samples.back().t_ns) return {};
  ImuMotion motion;
  pl::TimeNs now = times.front();
  for (const pl::TimeNs time : times) {
    while (now < time) {
      const pl::ImuSample& sample = *std::prev(next);
      const pl::TimeNs until = std::min(time, next->t_ns);
      const double dt = pl::seconds_between(now, until);
      const Vector3 force = (sample.accel + next->accel) / 2, rate = (sample.gyro + next->gyro) / 2 - gyro_bias;
      const Vector3 in_begin = motion.R * (SO3::exp(dt / 2 * rate) * force);
      motion.position += dt * motion.velocity + dt * dt / 2 * in_begin;
      motion.velocity += dt * in_begin;
      motion.R = motion.R * SO3::exp(dt * rate);
      now = until;
      if (now == next->t_ns && std::next(next) != samples.end()) ++next;
    }
    motion.t_s = pl::seconds_between(times.front(), time);
    out.push_back(motion);
  }
  return out;
}

Points points_from_depth(const TrackedFrame& frame) {
  Points out;
  for (const TrackedCorner& corner : frame.corners)
    if (corner.depth_m > 0 && corner.bearing.z() > 0.1)
      out[corner.id] = corner.bearing * (corner.depth_m / corner.bearing.z());
  return out;
}

/// With a translation of length 1 between the two frames; none where they do not tell it.
Points points_from_views(const TrackedFrame& first, const TrackedFrame& second, const SO3& R_second_first,
                         double focal_length_px) {
  constexpr std::size_t most = 256;
  std::vector<pl::BearingPair<double>> pairs;
  std::vector<std::uint32_t> ids;
  for (const CornerPair& pair : pairs_of(first, second)) {
    if (pairs.size() == most) break;
    pairs.push_back({pair.first->bearing, pair.second->bearing});
    ids.push_back(pair.first->id);
  }
  pl::RelativePoseOptions options;
  options.sigma_rad = 1 / focal_length_px;
  options.min_inliers = 25;
  const auto pose = pl::RelativePoseSolver<double, most>().solve(pairs, R_second_first, options);
  Points out;
  if (!pose.valid) return out;
  const SE3& T = pose.two_view.T_2_1;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!pose.two_view.inlier[i]) continue;
    const Vector3 across = pairs[i].f2.cross(T.p());
    const double inverse_range = -pairs[i].f2.cross(T.rotation() * pairs[i].f1).dot(across) / across.squaredNorm();
    if (inverse_range > 0.02) out[ids[i]] = pairs[i].f1 / inverse_range;
  }
  return out;
}

/// Pose by known points, from a guess: Gauss-Newton with the weights of a Cauchy loss on the plane z = 1.
std::optional<SE3> pose_from_points(const TrackedFrame& frame, const Points& points, SE3 T, double sigma) {
  for (int iteration = 0; iteration < 10; ++iteration) {
    pl::Mat<double, 6, 6> H = pl::Mat<double, 6, 6>::Zero();
    pl::Vec<double, 6> b = pl::Vec<double, 6>::Zero();
    std::size_t seen = 0;
    for (const TrackedCorner& corner : frame.corners) {
      const auto point = points.find(corner.id);
      if (point == points.end() || !(corner.bearing.z() > 0.1)) continue;
      const Vector3 p = T * point->second;
      if (!(p.z() > 1e-3)) continue;
      const pl::Vec<double, 2> r = p.head<2>() / p.z() - corner.bearing.head<2>() / corner.bearing.z();
      pl::Mat<double, 2, 3> J_p;
      J_p << 1 / p.z(), 0, -p.x() / (p.z() * p.z()), 0, 1 / p.z(), -p.y() / (p.z() * p.z());
      pl::Mat<double, 2, 6> J;  // of T by a rotation and a translation on its left
      J << -J_p * pl::hat(p), J_p;
      const double weight = 1 / (1 + r.squaredNorm() / (4 * sigma * sigma));
      H += weight * J.transpose() * J;
      b -= weight * J.transpose() * r;
      ++seen;
    }
    if (seen < least_points) return std::nullopt;
    const pl::Vec<double, 6> d = H.ldlt().solve(b);
    if (!d.allFinite()) return std::nullopt;
    const SO3 dR = SO3::exp(Vector3(d.head<3>()));
    T = SE3(dR * T.rotation(), dR * T.p() + d.tail<3>());
    if (d.norm() < 1e-7) return T;
  }
  return T;
}

/// Least squares for 1/s, v/s and g/s.
std::optional<WindowScale> solve_window(const std::vector<ImuMotion>& motions, const std::vector<Vector3>& ways,
                                        const Vector3& lever) {
  using Matrix7 = Eigen::Matrix<double, 7, 7>;
  using Vector7 = Eigen::Matrix<double, 7, 1>;
  Matrix7 H = Matrix7::Zero();
  Vector7 b = Vector7::Zero();
  double squares = 0;
  for (std::size_t k = 0; k < motions.size(); ++k) {
    const double t = motions[k].t_s;
    Eigen::Matrix<double, 3, 7> J;
    J << motions[k].position + (motions[k].R * lever - lever), t * pl::Mat<double, 3, 3>::Identity(),
        t * t / 2 * pl::Mat<double, 3, 3>::Identity();
    H += J.transpose() * J;
    b += J.transpose() * ways[k];
    squares += ways[k].squaredNorm();
  }
  const Eigen::LDLT<Matrix7> ldlt(H);
  const Vector7 x = ldlt.solve(b);
  if (!x.allFinite() || x[0] == 0) return std::nullopt;
  const double n = 3 * double(motions.size()) - 7, variance = std::max(squares - b.dot(x), 0.0) / n;
  const double sigma = std::sqrt(variance * ldlt.solve(Vector7::Unit(0))[0]);
  return WindowScale{1 / x[0], sigma / (x[0] * x[0]), x.tail<3>().norm() / std::abs(x[0])};
}

}  // namespace

std::vector<WindowScale> fit_scales(const std::vector<TrackedFrame>& frames, const std::vector<pl::ImuSample>& samples,
                                    const CameraOnImu& camera, bool with_depth, double focal_length_px) {
  constexpr double longest_s = 2, shortest_s = 0.7, step_s = 0.5;
  const SO3& R_imu_cam = camera.T_imu_cam.rotation();
  const pl::TimeNs offset_ns = std::llround(1e9 * camera.time_offset_s);
  std::vector<WindowScale> out;
  if (samples.size() < 2) return out;
  pl::TimeNs next_ns = frames.empty() ? 0 : frames.front().t_ns;
  for (std::size_t first = 0; first + 8 < frames.size(); ++first) {
    if (frames[first].t_ns < next_ns) continue;
    if (with_depth && points_from_depth(frames[first]).size() < least_points) continue;
    std::size_t last = first;
    while (last + 1 < frames.size() && frames[last + 1].follows &&
           pl::seconds_between(frames[first].t_ns, frames[last + 1].t_ns) < longest_s &&
           pairs_of(frames[first], frames[last + 1]).size() > 20)
      ++last;
    if (last < first + 8 || pl::seconds_between(frames[first].t_ns, frames[last].t_ns) < shortest_s) continue;
    next_ns = frames[first].t_ns + std::llround(1e9 * step_s);

    std::vector<pl::TimeNs> times;
    for (std::size_t k = first; k <= last; ++k) times.push_back(frames[k].t_ns + offset_ns);
    std::vector<ImuMotion> motions = integrate(samples, times, camera.gyro_bias);
    if (motions.empty()) continue;
    const auto R_k_first = [&](std::size_t k) { return (R_imu_cam.inverse() * motions[k].R * R_imu_cam).inverse(); };
    const Points points =
        with_depth ? points_from_depth(frames[first])
                   : points_from_views(frames[first], frames[last], R_k_first(last - first), focal_length_px);
    if (points.size() < least_points) continue;
    std::vector<ImuMotion> used;
    std::vector<Vector3> ways;
    SE3 T_k_first;
    for (std::size_t k = 1; k < motions.size(); ++k) {
      const auto pose =
          pose_from_points(frames[first + k], points, SE3(R_k_first(k), T_k_first.p()), 1 / focal_length_px);
      if (!pose) break;
      T_k_first = *pose;
      used.push_back(motions[k]);
      ways.push_back(R_imu_cam * T_k_first.inverse().p());
    }
    if (used.size() < 8 || used.back().t_s < shortest_s) continue;
    if (const auto scale = solve_window(used, ways, camera.T_imu_cam.p())) out.push_back(*scale);
  }
  return out;
}
