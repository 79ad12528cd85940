#pragma once
/// Pairs the poses of two trajectories by time and aligns the one to the other.
///                                                                       docs/guide/your_recording.md, "Evaluate"
///
/// The alignment S_reference_estimate minimizes the sum of squared distances of the pairs' positions. With yaw and
/// position only (gravity is observed), C = sum (p_ref - mu_ref)(p_est - mu_est)^T and mu the means:
///   R = Rz(atan2(C_10 - C_01, C_00 + C_11)),  t = mu_ref - R mu_est                                         (1)

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "plumbline/geometry/rigid_alignment.hpp"
#include "plumbline/io/association.hpp"
#include "plumbline/io/trajectory.hpp"
#include "plumbline/lie/sim3.hpp"

namespace plumbline::io {

struct PosePair {
  TimeNs t_ns;  ///< of the estimate
  SE3<double> reference, estimate;
};

/// Each pose of the estimate with the reference's nearest in time, at most `max_difference_s` away, each used once.
inline std::vector<PosePair> associate(const Trajectory& reference, const Trajectory& estimate,
                                       double max_difference_s) {
  constexpr double longest_s = 8e9;  // beyond any two times
  const TimeNs max_difference_ns = std::llround(std::min(max_difference_s, longest_s) * 1e9);
  std::vector<PosePair> pairs;
  for (const auto& [i, j] : associate_times(times_of(estimate), times_of(reference), max_difference_ns))
    pairs.push_back({estimate[i].t_ns, reference[j].T_world_body, estimate[i].T_world_body});
  return pairs;
}

enum class Alignment { none, se3, sim3, posyaw };

inline std::optional<Alignment> alignment_named(std::string_view name) {
  if (name == "none") return Alignment::none;
  if (name == "se3") return Alignment::se3;
  if (name == "sim3") return Alignment::sim3;
  if (name == "posyaw") return Alignment::posyaw;
  return std::nullopt;
}

/// The pose an aligned estimate has: the scale applies to its position alone.
inline SE3<double> aligned(const Sim3<double>& S_reference_estimate, const SE3<double>& pose) {
  return {S_reference_estimate.rotation() * pose.rotation(), S_reference_estimate * pose.p()};
}

namespace detail {

/// (1); the mean positions are subtracted first, so that nothing cancels far from the origin.
inline Sim3<double> align_yaw(const std::vector<PosePair>& pairs) {
  const double n = static_cast<double>(pairs.size());
  Vec<double, 3> mean_reference = Vec<double, 3>::Zero(), mean_estimate = Vec<double, 3>::Zero();
  for (const PosePair& pair : pairs) {
    mean_reference += pair.reference.p() / n;
    mean_estimate += pair.estimate.p() / n;
  }
  Mat<double, 3, 3> C = Mat<double, 3, 3>::Zero();
  for (const PosePair& pair : pairs)
    C += (pair.reference.p() - mean_reference) * (pair.estimate.p() - mean_estimate).transpose();
  const SO3<double> R = SO3<double>::exp({0, 0, std::atan2(C(1, 0) - C(0, 1), C(0, 0) + C(1, 1))});
  return Sim3<double>(1, R, mean_reference - R * mean_estimate);
}

}  // namespace detail

/// S_reference_estimate. Empty for fewer than three pairs, or positions on one line: nothing to align by.
inline std::optional<Sim3<double>> align(const std::vector<PosePair>& pairs, Alignment alignment) {
  constexpr double collinear_ratio = 1e-12;  // only what is exactly a line: cars drive nearly straight for long
  if (alignment == Alignment::none) return Sim3<double>();
  RigidAlignment<double> moments;
  for (const PosePair& pair : pairs) moments.add(pair.reference.p(), pair.estimate.p());
  const RigidAlignment<double>::Result result = moments.solve(alignment == Alignment::sim3, collinear_ratio);
  if (!result.valid) return std::nullopt;
  return alignment == Alignment::posyaw ? detail::align_yaw(pairs) : result.S_p_q;
}

}  // namespace plumbline::io
