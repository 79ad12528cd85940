#include "truth_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "plumbline/core/square_root_information.hpp"
#include "plumbline/io/trajectory_alignment.hpp"
#include "plumbline/lie/interpolate.hpp"
#include "plumbline/lie/plus.hpp"

namespace pl = plumbline;
namespace io = plumbline::io;

namespace {

/// T_estimate_reference that carries one pose of the reference to that of the estimate.
pl::SE3<double> alignment_at(const io::PosePair& pair, bool gravity_is_known) {
  pl::SO3<double> R = pair.estimate.rotation() * pair.reference.rotation().inverse();
  if (gravity_is_known)
    R = pl::SO3<double>::exp(
        {0, 0, std::atan2(R.matrix()(1, 0) - R.matrix()(0, 1), R.matrix()(0, 0) + R.matrix()(1, 1))});
  return {R, pair.estimate.p() - R * pair.reference.p()};
}

constexpr double min_extent_m = 1;

/// Largest distance from the first position.
double extent_of(const std::vector<io::PosePair>& pairs) {
  double extent_m = 0;
  for (const io::PosePair& pair : pairs)
    extent_m = std::max(extent_m, (pair.reference.p() - pairs.front().reference.p()).norm());
  return extent_m;
}

template <int N>
double nees(const pl::Vec<double, N>& e, const pl::Mat<double, N, N>& covariance) {
  const auto L = pl::square_root_information(covariance);
  return L ? (*L * e).squaredNorm() : std::nan("");
}

}  // namespace

std::optional<pl::SE3<double>> truth_at(const io::Trajectory& truth, pl::TimeNs t_ns) {
  constexpr double max_gap_s = 0.1;
  const auto after = std::lower_bound(truth.begin(), truth.end(), t_ns,
                                      [](const io::StampedPose& pose, pl::TimeNs t) { return pose.t_ns < t; });
  if (after == truth.end()) return std::nullopt;
  if (after->t_ns == t_ns) return after->T_world_body;
  if (after == truth.begin()) return std::nullopt;
  const auto before = after - 1;
  const double gap_s = pl::seconds_between(before->t_ns, after->t_ns);
  if (!(gap_s < max_gap_s)) return std::nullopt;
  const auto between =
      pl::interpolate(before->T_world_body, after->T_world_body, pl::seconds_between(before->t_ns, t_ns) / gap_s);
  return between.valid ? std::optional(between.T) : std::nullopt;
}

TruthComparison compare_with_truth(const io::Trajectory& truth, const std::vector<EstimatedPose>& estimates,
                                   bool gravity_is_known, const std::optional<pl::SO3<double>>& heading) {
  std::vector<io::PosePair> pairs;
  std::vector<pl::Mat<double, 6, 6>> covariances;
  for (const EstimatedPose& estimate : estimates) {
    const auto reference = truth_at(truth, estimate.t_ns);
    if (!reference) continue;
    pairs.push_back({estimate.t_ns, *reference, estimate.T_world_body});
    covariances.push_back(estimate.covariance);
  }
  TruthComparison out;
  if (pairs.empty()) return out;

  const pl::SE3<double> at_first = alignment_at(pairs.front(), gravity_is_known);
  pl::SE3<double> whole = at_first;  // where nothing moved there is no better one
  if (const auto S = io::align(pairs, gravity_is_known ? io::Alignment::posyaw : io::Alignment::se3)) {
    whole = pl::SE3<double>(S->rotation(), S->t()).inverse();
    // True positions are accurate to millimeters, true attitudes to a degree: over meters positions determine the
    // heading better.
    if (gravity_is_known && extent_of(pairs) > min_extent_m)
      out.heading = at_first.rotation().inverse() * whole.rotation();
  }
  if (heading) out.heading = *heading;
  const pl::SO3<double> R = at_first.rotation() * out.heading;
  const pl::SE3<double> origin{R, pairs.front().estimate.p() - R * pairs.front().reference.p()};
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    using Vec3 = pl::Vec<double, 3>;
    using Mat3 = pl::Mat<double, 3, 3>;
    pl::Vec<double, 6> e = pl::minus(at_first * pairs[i].reference, pairs[i].estimate);
    e.tail<3>() = pl::minus(origin * pairs[i].reference, pairs[i].estimate).tail<3>();
    out.errors.push_back({pairs[i].t_ns, pl::minus(whole * pairs[i].reference, pairs[i].estimate),
                          nees<3>(Vec3(e.head<3>()), Mat3(covariances[i].topLeftCorner<3, 3>())),
                          nees<3>(Vec3(e.tail<3>()), Mat3(covariances[i].bottomRightCorner<3, 3>())),
                          nees<6>(e, covariances[i])});
  }
  return out;
}

double position_rmse(const std::vector<TruthError>& errors) {
  double sum = 0;
  for (const TruthError& each : errors) sum += each.error.tail<3>().squaredNorm();
  return std::sqrt(sum / static_cast<double>(errors.size()));
}
