#pragma once
/// The whole comparison of an estimated trajectory with the true one.
///                                                                       docs/guide/your_recording.md, "Evaluate"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "plumbline/io/trajectory_alignment.hpp"
#include "plumbline/io/trajectory_error.hpp"

namespace plumbline::io {

struct EvaluationSettings {
  Alignment alignment = Alignment::se3;
  double max_difference_s = 0.02;  ///< between the times of a pair of poses
  double rpe_delta = 1;            ///< in rpe_unit
  DeltaUnit rpe_unit = DeltaUnit::seconds;
};

/// How far one pose is from the truth.
struct StampedError {
  TimeNs t_ns;  ///< of the estimate
  double position_m;
};

struct Evaluation {
  std::size_t poses = 0;     ///< of the estimate
  std::size_t pairs = 0;     ///< poses of the estimate that have one of the reference
  double coverage = 0;       ///< share of the reference's seconds in which there is at least one pair
  double path_length_m = 0;  ///< along the reference's poses of the pairs
  double scale = 1;          ///< of the Sim(3) alignment, whichever alignment was asked for; NaN where it has none
  PoseError ape, rpe;
  std::vector<StampedError> errors;  ///< of the pairs, aligned
  Trajectory aligned;                ///< the whole estimate in the reference's world
};

/// The share of the reference's seconds (0-1 s, 1-2 s ... after its first pose, those without a pose left out) in which
/// the estimate has a pose that is paired.
inline double coverage(const Trajectory& reference, const std::vector<PosePair>& pairs) {
  const TimeNs first = reference.front().t_ns, last = reference.back().t_ns;
  const auto second = [&](TimeNs t) { return (std::clamp(t, first, last) - first) / 1'000'000'000; };
  std::set<TimeNs> all, covered;
  for (const StampedPose& pose : reference) all.insert(second(pose.t_ns));
  for (const PosePair& pair : pairs)
    if (const TimeNs s = second(pair.t_ns); all.contains(s)) covered.insert(s);
  return static_cast<double>(covered.size()) / static_cast<double>(all.size());
}

/// Whether so many pairs suffice to compare two trajectories: two of a hundred that there could be, and where they are
/// not even ten, one of ten of the longer one.
inline bool are_enough(std::size_t pairs, std::size_t reference, std::size_t estimate) {
  if (50 * pairs < std::min(reference, estimate)) return false;
  return pairs >= 10 || 10 * pairs >= std::max(reference, estimate);
}

/// Throws std::runtime_error when the two have too little in common.
inline Evaluation evaluate_trajectory(const Trajectory& reference, const Trajectory& estimate,
                                      const EvaluationSettings& settings) {
  std::vector<PosePair> pairs = associate(reference, estimate, settings.max_difference_s);
  if (pairs.empty())
    throw std::runtime_error("no pose of the estimate is within " + std::to_string(settings.max_difference_s) +
                             " s of one of the reference: do both use the same clock?");
  if (!are_enough(pairs.size(), reference.size(), estimate.size()))
    throw std::runtime_error(std::to_string(pairs.size()) + " of " + std::to_string(estimate.size()) +
                             " poses have a partner among the reference's " + std::to_string(reference.size()) +
                             ": too few to compare; do both use the same clock, and is the estimate complete?");
  const std::optional<Sim3<double>> alignment = align(pairs, settings.alignment);
  if (!alignment)
    throw std::runtime_error("cannot align " + std::to_string(pairs.size()) +
                             " pairs of poses: fewer than three, or all on one line");
  const std::optional<Sim3<double>> similarity = align(pairs, Alignment::sim3);

  Evaluation out;
  out.poses = estimate.size();
  out.pairs = pairs.size();
  out.coverage = coverage(reference, pairs);
  out.scale = similarity ? similarity->scale() : std::nan("");
  out.aligned = estimate;
  for (StampedPose& pose : out.aligned) pose.T_world_body = aligned(*alignment, pose.T_world_body);
  for (PosePair& pair : pairs) pair.estimate = aligned(*alignment, pair.estimate);
  for (std::size_t i = 1; i < pairs.size(); ++i)
    out.path_length_m += (pairs[i].reference.p() - pairs[i - 1].reference.p()).norm();
  for (const PosePair& pair : pairs) out.errors.push_back({pair.t_ns, (pair.reference.p() - pair.estimate.p()).norm()});
  out.ape = absolute_error(pairs);
  switch (settings.rpe_unit) {
    case DeltaUnit::seconds: out.rpe = relative_error_over_time(reference, out.aligned, settings.rpe_delta); break;
    case DeltaUnit::meters: out.rpe = relative_error(pairs, pairs_by_meters(pairs, settings.rpe_delta)); break;
    case DeltaUnit::frames:
      out.rpe = relative_error(pairs, pairs_by_frames(pairs.size(), static_cast<std::size_t>(settings.rpe_delta)));
      break;
  }
  return out;
}

}  // namespace plumbline::io
