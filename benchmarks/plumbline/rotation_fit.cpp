#include "rotation_fit.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include "plumbline/geometry/relative_pose.hpp"
#include "statistics.hpp"

namespace pl = plumbline;

namespace {

using Vector3 = pl::Vec<double, 3>;
using Matrix3 = pl::Mat<double, 3, 3>;

/// The fit at one time offset; without rates where the samples cover too few.
struct OffsetFit {
  std::size_t n = 0;
  double correlation = 0, mirrored = 0, slope = 0;
  Matrix3 R_cam_imu = Matrix3::Identity(), spread = Matrix3::Zero();
  Vector3 mean_image = Vector3::Zero(), mean_gyro = Vector3::Zero();
  double image_squares = 0;
};

OffsetFit fit_at(const std::vector<ImageRate>& rates, const GyroscopeIntegral& gyro, double offset_s) {
  const pl::TimeNs offset_ns = std::llround(1e9 * offset_s);
  std::vector<std::pair<Vector3, Vector3>> pairs;
  OffsetFit out;
  for (const ImageRate& rate : rates) {
    const pl::TimeNs begin = rate.begin_ns + offset_ns, end = rate.end_ns + offset_ns;
    if (!gyro.covers(begin, end)) continue;
    pairs.emplace_back(rate.rate, gyro.mean_rate(begin, end));
    out.mean_image += pairs.back().first;
    out.mean_gyro += pairs.back().second;
  }
  if (pairs.size() < 10 || 10 * pairs.size() < 6 * rates.size()) return out;
  out.n = pairs.size();
  out.mean_image /= double(out.n);
  out.mean_gyro /= double(out.n);
  Matrix3 H = Matrix3::Zero();
  for (const auto& [image, sample] : pairs) {
    const Vector3 c = image - out.mean_image, w = sample - out.mean_gyro;
    H += c * w.transpose();
    out.spread += w * w.transpose();
    out.image_squares += c.squaredNorm();
  }
  const Eigen::JacobiSVD<Matrix3, Eigen::ComputeFullU | Eigen::ComputeFullV> svd(
      H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double det = (svd.matrixU() * svd.matrixV().transpose()).determinant() > 0 ? 1 : -1;
  const Vector3 s = svd.singularValues();
  out.R_cam_imu = svd.matrixU() * Vector3(1, 1, det).asDiagonal() * svd.matrixV().transpose();
  const double norm = std::sqrt(out.image_squares * out.spread.trace());
  if (!(norm > 0)) return {};
  out.correlation = (s[0] + s[1] + det * s[2]) / norm;
  out.mirrored = (s[0] + s[1] - det * s[2]) / norm;
  out.slope = (s[0] + s[1] + det * s[2]) / out.spread.trace();
  return out;
}

/// The time offset of the highest correlation: on a grid, then around its best.
double best_offset(const std::vector<ImageRate>& rates, const GyroscopeIntegral& gyro) {
  constexpr double farthest_s = 0.6;
  double best_s = 0, best = -1;
  const auto search = [&](double begin_s, double end_s, double step_s) {
    for (double offset_s = begin_s; offset_s <= end_s; offset_s += step_s) {
      const OffsetFit fit = fit_at(rates, gyro, offset_s);
      const double score = std::max(fit.correlation, fit.mirrored);
      if (fit.n == 0 || !(score > best)) continue;
      best = score;
      best_s = offset_s;
    }
  };
  search(-farthest_s, farthest_s, 0.01);
  for (const double step_s : {0.002, 0.0005}) search(best_s - 5 * step_s, best_s + 5 * step_s, step_s);
  return best_s;
}

Vector3 residual_of(const ImageRate& rate, const GyroscopeIntegral& gyro, const OffsetFit& fit, pl::TimeNs offset_ns) {
  const Vector3 w = gyro.mean_rate(rate.begin_ns + offset_ns, rate.end_ns + offset_ns);
  return rate.rate - fit.mean_image - fit.R_cam_imu * (w - fit.mean_gyro);
}

/// The frame after `first` in which corners have moved by so many pixels, or the last one in which enough of them are
/// followed; `first` where there is none. The rotation of images that hardly move is mistaken for a translation.
std::size_t far_enough(const std::vector<TrackedFrame>& frames, std::size_t first, double least_px) {
  constexpr double longest_s = 0.4;
  std::size_t out = first;
  for (std::size_t k = first + 1; k < frames.size() && frames[k].follows; ++k) {
    if (pl::seconds_between(frames[first].t_ns, frames[k].t_ns) > longest_s) break;
    std::vector<double> moved;
    for (const CornerPair& pair : pairs_of(frames[first], frames[k]))
      moved.push_back((pair.second->uv - pair.first->uv).norm());
    if (moved.size() < 30) break;
    out = k;
    if (median(moved) > least_px) break;
  }
  return out;
}

/// Rotation from one frame to the one after it that is far enough.
struct ImageMotion {
  std::size_t second;
  pl::SO3<double> rotation;
  double noise_rad;
};

/// Nothing where the corners do not fit one motion.
std::optional<ImageMotion> motion_from(const std::vector<TrackedFrame>& frames, std::size_t first,
                                       double focal_length_px, double noise_rad) {
  constexpr std::size_t most_pairs = 256;
  constexpr double least_motion = 0.1;  // [rad]
  const std::size_t second = far_enough(frames, first, least_motion * focal_length_px);
  if (second == first) return std::nullopt;
  pl::RelativePoseOptions options;
  options.sigma_rad = noise_rad;
  options.min_inliers = 25;
  std::vector<pl::BearingPair<double>> pairs;
  for (const CornerPair& pair : pairs_of(frames[first], frames[second]))
    if (pairs.size() < most_pairs) pairs.push_back({pair.first->bearing, pair.second->bearing});
  const auto pose = pl::RelativePoseSolver<double, most_pairs>().solve(pairs, pl::SO3<double>(), options);
  if (pose.failure == pl::TwoViewFailure::few_pairs || pose.failure == pl::TwoViewFailure::no_consensus)
    return std::nullopt;
  return ImageMotion{second, pose.two_view.T_2_1.rotation(), pose.noise_rad};
}

}  // namespace

double corner_noise(const std::vector<TrackedFrame>& frames, double focal_length_px) {
  constexpr std::size_t most_pairs = 30;
  constexpr int rounds = 3;  // where the noise is overrated, so are the errors of a wrong model
  double noise = 0.5 / focal_length_px;
  for (int round = 0; round < rounds; ++round) {
    std::vector<double> found;
    for (std::size_t k = 0; k < most_pairs && frames.size() > 1; ++k) {
      const auto motion = motion_from(frames, k * (frames.size() - 1) / most_pairs, focal_length_px, noise);
      if (motion) found.push_back(motion->noise_rad);
    }
    if (!found.empty()) noise = std::max(median(found), least_noise_px / focal_length_px);
  }
  return noise;
}

std::vector<ImageRate> image_rates_of(const std::vector<TrackedFrame>& frames, double focal_length_px) {
  constexpr std::size_t most_rates = 500;  // those of neighbors overlap
  const double noise = corner_noise(frames, focal_length_px);
  const std::size_t step = (frames.size() + most_rates - 1) / most_rates;
  std::vector<ImageRate> out;
  for (std::size_t i = 0; i + 1 < frames.size(); i += step) {
    const auto motion = motion_from(frames, i, focal_length_px, noise);
    if (!motion) continue;
    const TrackedFrame &first = frames[i], &second = frames[motion->second];
    const double dt = pl::seconds_between(first.t_ns, second.t_ns);
    out.push_back({first.t_ns, second.t_ns, -motion->rotation.log() / dt, i, motion->second});
  }
  return out;
}

GyroscopeIntegral::GyroscopeIntegral(const std::vector<pl::ImuSample>& samples) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (i > 0)
      sum += pl::seconds_between(samples[i - 1].t_ns, samples[i].t_ns) / 2 * (samples[i - 1].gyro + samples[i].gyro);
    times_.push_back(samples[i].t_ns);
    integral_.push_back(sum);
  }
}

bool GyroscopeIntegral::covers(pl::TimeNs begin_ns, pl::TimeNs end_ns) const {
  return times_.size() > 1 && begin_ns >= times_.front() && end_ns <= times_.back();
}

Vector3 GyroscopeIntegral::mean_rate(pl::TimeNs begin_ns, pl::TimeNs end_ns) const {
  return (at(end_ns) - at(begin_ns)) / pl::seconds_between(begin_ns, end_ns);
}

Vector3 GyroscopeIntegral::at(pl::TimeNs t_ns) const {
  const auto after = std::upper_bound(times_.begin() + 1, times_.end() - 1, t_ns);
  const std::size_t i = std::size_t(after - times_.begin());
  const double part = pl::seconds_between(times_[i - 1], t_ns) / pl::seconds_between(times_[i - 1], times_[i]);
  return (1 - part) * integral_[i - 1] + part * integral_[i];
}

RotationFit fit_rotation(const std::vector<ImageRate>& rates, const std::vector<pl::ImuSample>& samples) {
  const GyroscopeIntegral gyro(samples);
  std::vector<ImageRate> used = rates;
  RotationFit out;
  OffsetFit fit;
  double sigma = 0;
  for (int round = 0; round < 3; ++round) {
    out.time_offset_s = best_offset(used, gyro);
    fit = fit_at(used, gyro, out.time_offset_s);
    if (fit.n == 0) return out;
    const pl::TimeNs offset_ns = std::llround(1e9 * out.time_offset_s);
    std::erase_if(used, [&](const ImageRate& r) { return !gyro.covers(r.begin_ns + offset_ns, r.end_ns + offset_ns); });
    std::vector<double> errors;
    for (const ImageRate& rate : used) errors.push_back(residual_of(rate, gyro, fit, offset_ns).norm());
    sigma = median(errors) / std::sqrt(2.366);  // the median of chi-square with three degrees of freedom
    if (round < 2)
      std::erase_if(used,
                    [&](const ImageRate& r) { return residual_of(r, gyro, fit, offset_ns).norm() > 4 * sigma + 1e-3; });
  }
  out.rates = fit.n;
  out.rms_rate = std::sqrt(fit.image_squares / double(fit.n));
  out.correlation = fit.correlation;
  out.mirrored_correlation = fit.mirrored;
  out.slope = fit.slope;
  out.R_imu_cam = pl::SO3<double>::from_matrix(Matrix3(fit.R_cam_imu.transpose()));
  out.gyro_bias = fit.mean_gyro - fit.R_cam_imu.transpose() * fit.mean_image;
  double change = 0;  // squared, of the gyroscope's rates by the offset
  constexpr pl::TimeNs step_ns = 5'000'000;
  const pl::TimeNs offset_ns = std::llround(1e9 * out.time_offset_s);
  for (const ImageRate& rate : used) {
    const pl::TimeNs begin = rate.begin_ns + offset_ns, end = rate.end_ns + offset_ns;
    if (!gyro.covers(begin - step_ns, end + step_ns)) continue;
    const Vector3 later = gyro.mean_rate(begin + step_ns, end + step_ns);
    change += ((later - gyro.mean_rate(begin - step_ns, end - step_ns)) / (2e-9 * double(step_ns))).squaredNorm();
  }
  constexpr double common = 3;  // the errors of rates that overlap are not independent
  out.sigma_offset_s = common * sigma / std::sqrt(change);
  const Vector3 spread = Eigen::SelfAdjointEigenSolver<Matrix3>(fit.spread).eigenvalues();
  out.sigma_rad = sigma / std::sqrt(spread[0] + spread[1]);  // about the axis of the largest one
  return out;
}
