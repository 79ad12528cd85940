#pragma once
/// How far an estimated trajectory is from the true one, by the definitions of the evo tool.
///                                                                                        docs/guide/your_recording.md
///
///   absolute (ATE, APE):  e_i  = |p_ref,i - p_aligned,i|,  angle(R_aligned,i^T R_ref,i)                      (1)
///   relative (RPE):       E_ij = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j),  Q reference, P estimate;  |trans E|, angle E (2)
/// The pairs (i, j) of the relative error:
///   frames, meters  consecutive stretches: each begins where the one before ended; meters along the estimate's path
///   seconds         every i, with j the pose nearest to t_i + delta, as the TUM benchmark's tool pairs them
/// The standard deviation is that of the population.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "plumbline/io/association.hpp"
#include "plumbline/io/trajectory_alignment.hpp"

namespace plumbline::io {

struct Statistics {
  std::size_t count = 0;
  double rmse = 0, mean = 0, median = 0, std = 0, min = 0, max = 0;
};

inline Statistics statistics(std::vector<double> errors) {
  Statistics out;
  out.count = errors.size();
  if (errors.empty()) return out;
  std::sort(errors.begin(), errors.end());
  const double n = static_cast<double>(errors.size());
  double squares = 0, deviations = 0;
  for (const double e : errors) {
    out.mean += e / n;
    squares += e * e / n;
  }
  for (const double e : errors) deviations += (e - out.mean) * (e - out.mean) / n;
  out.rmse = std::sqrt(squares);
  out.std = std::sqrt(deviations);
  out.median = (errors[(errors.size() - 1) / 2] + errors[errors.size() / 2]) / 2;
  out.min = errors.front();
  out.max = errors.back();
  return out;
}

struct PoseError {
  Statistics translation;   ///< [m]
  Statistics rotation_deg;  ///< [deg]
};

namespace detail {

inline double angle_deg(const SO3<double>& R) { return R.log().norm() * (180 / 3.14159265358979323846); }

}  // namespace detail

/// (1) of pairs that are already aligned.
inline PoseError absolute_error(const std::vector<PosePair>& pairs) {
  std::vector<double> translation, rotation;
  for (const PosePair& pair : pairs) {
    translation.push_back((pair.reference.p() - pair.estimate.p()).norm());
    rotation.push_back(detail::angle_deg(pair.estimate.rotation().inverse() * pair.reference.rotation()));
  }
  return {statistics(std::move(translation)), statistics(std::move(rotation))};
}

enum class DeltaUnit { seconds, frames, meters };

inline std::optional<DeltaUnit> delta_unit_named(std::string_view name) {
  if (name == "s") return DeltaUnit::seconds;
  if (name == "frames") return DeltaUnit::frames;
  if (name == "m") return DeltaUnit::meters;
  return std::nullopt;
}

/// Consecutive stretches of `delta` poses.
inline IndexPairs pairs_by_frames(std::size_t count, std::size_t delta) {
  IndexPairs out;
  for (std::size_t i = 0; delta > 0 && i + delta < count; i += delta) out.emplace_back(i, i + delta);
  return out;
}

/// Consecutive stretches of at least `delta` meters along the estimated path; the first begins after the first `delta`.
inline IndexPairs pairs_by_meters(const std::vector<PosePair>& pairs, double delta) {
  IndexPairs out;
  std::optional<std::size_t> begin;
  double path = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (i > 0) path += (pairs[i].estimate.p() - pairs[i - 1].estimate.p()).norm();
    if (!(path >= delta)) continue;
    if (begin) out.emplace_back(*begin, i);
    begin = i;
    path = 0;
  }
  return out;
}

/// The relative error (2) over stretches of `delta` frames or meters of associated pairs.
inline PoseError relative_error(const std::vector<PosePair>& pairs, const IndexPairs& stretches) {
  std::vector<double> translation, rotation;
  for (const auto& [i, j] : stretches) {
    const SE3<double> reference = pairs[i].reference.inverse() * pairs[j].reference;
    const SE3<double> E = reference.inverse() * (pairs[i].estimate.inverse() * pairs[j].estimate);
    translation.push_back(E.p().norm());
    rotation.push_back(detail::angle_deg(E.rotation()));
  }
  return {statistics(std::move(translation)), statistics(std::move(rotation))};
}

namespace detail {

inline std::size_t nearest_index(const Trajectory& trajectory, TimeNs t) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), t,
                                      [](const StampedPose& a, TimeNs b) { return a.t_ns < b; });
  if (after == trajectory.begin()) return 0;
  const std::size_t i = static_cast<std::size_t>(after - trajectory.begin());
  if (i == trajectory.size()) return i - 1;
  const double before = seconds(t) - seconds(trajectory[i - 1].t_ns), behind = seconds(trajectory[i].t_ns) - seconds(t);
  return before <= behind ? i - 1 : i;
}

/// The usual distance in time between two poses: the median.
inline TimeNs median_interval(const Trajectory& trajectory) {
  std::vector<TimeNs> intervals;
  for (std::size_t i = 1; i < trajectory.size(); ++i) intervals.push_back(trajectory[i].t_ns - trajectory[i - 1].t_ns);
  if (intervals.empty()) return 0;
  std::sort(intervals.begin(), intervals.end());
  return (intervals[(intervals.size() - 1) / 2] + intervals[intervals.size() / 2]) / 2;
}

}  // namespace detail

/// The relative error (2) over `delta_s` seconds, paired as the TUM benchmark's tool does: each pose i of the estimate
/// with the pose j nearest to t_i + delta unless j is the last one; the reference's poses nearest to both, at most two
/// of its usual intervals away. That tool measures the motion from j back to i, and so does this function.
inline PoseError relative_error_over_time(const Trajectory& reference, const Trajectory& estimate, double delta_s) {
  std::vector<PosePair> ends;
  IndexPairs stretches;
  const TimeNs delta_ns = std::llround(delta_s * 1e9), reach_ns = 2 * detail::median_interval(reference);
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const std::size_t j = detail::nearest_index(estimate, estimate[i].t_ns + delta_ns);
    if (j + 1 == estimate.size()) continue;
    const StampedPose& at_i = reference[detail::nearest_index(reference, estimate[i].t_ns)];
    const StampedPose& at_j = reference[detail::nearest_index(reference, estimate[j].t_ns)];
    if (std::abs(at_i.t_ns - estimate[i].t_ns) > reach_ns || std::abs(at_j.t_ns - estimate[j].t_ns) > reach_ns)
      continue;
    ends.push_back({estimate[i].t_ns, at_i.T_world_body, estimate[i].T_world_body});
    ends.push_back({estimate[j].t_ns, at_j.T_world_body, estimate[j].T_world_body});
    stretches.emplace_back(ends.size() - 1, ends.size() - 2);
  }
  return relative_error(ends, stretches);
}

}  // namespace plumbline::io
