#include "epipolar_fit.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "plumbline/core/time.hpp"
#include "statistics.hpp"

namespace pl = plumbline;

namespace {

using Vector3 = pl::Vec<double, 3>;
using Matrix3 = pl::Mat<double, 3, 3>;
using SO3 = pl::SO3<double>;
using Vector7 = pl::Vec<double, 7>;  // offset, rotation, bias
using Matrix7 = pl::Mat<double, 7, 7>;

/// Orientation by a gyroscope without its bias, from the first sample on.
class GyroscopeOrientation {
 public:
  struct State {
    Matrix3 R;         ///< orientation
    Matrix3 integral;  ///< of the orientation over time
    Vector3 rate;
  };

  GyroscopeOrientation(const std::vector<pl::ImuSample>& samples, const Vector3& bias)
      : samples_(samples), bias_(bias) {
    nodes_.reserve(samples.size());
    nodes_.push_back({Matrix3::Identity(), Matrix3::Zero(), samples.front().gyro - bias});
    for (std::size_t i = 1; i < samples.size(); ++i)
      nodes_.push_back(after(i - 1, pl::seconds_between(samples[i - 1].t_ns, samples[i].t_ns)));
  }

  bool covers(pl::TimeNs t_ns) const { return t_ns >= samples_.front().t_ns && t_ns < samples_.back().t_ns; }
  /// At t + d, which must be covered; d is not rounded to nanoseconds, so that derivatives by it are exact.
  State at(pl::TimeNs t_ns, double offset_s) const {
    const pl::TimeNs time = t_ns + std::llround(1e9 * offset_s);
    const auto next = std::upper_bound(samples_.begin() + 1, samples_.end() - 1, time,
                                       [](pl::TimeNs t, const pl::ImuSample& sample) { return t < sample.t_ns; });
    const std::size_t i = std::size_t(next - samples_.begin()) - 1;
    return after(i, pl::seconds_between(samples_[i].t_ns, t_ns) + offset_s);
  }

 private:
  /// `dt` after sample i, which is not the last.
  State after(std::size_t i, double dt) const {
    const double part = dt / pl::seconds_between(samples_[i].t_ns, samples_[i + 1].t_ns);
    const Vector3 end = (1 - part) * samples_[i].gyro + part * samples_[i + 1].gyro - bias_;
    const Vector3 mean = (nodes_[i].rate + end) / 2;
    return {nodes_[i].R * SO3::exp(Vector3(dt * mean)).matrix(),
            nodes_[i].integral + dt * nodes_[i].R * SO3::exp(Vector3(dt / 2 * mean)).matrix(), end};
  }

  const std::vector<pl::ImuSample>& samples_;
  Vector3 bias_;
  std::vector<State> nodes_;
};

/// The corners of two frames.
struct FramePair {
  pl::TimeNs first_ns, second_ns;
  std::vector<std::pair<Vector3, Vector3>> bearings;
};

std::vector<FramePair> frame_pairs(const std::vector<TrackedFrame>& frames, const std::vector<ImageRate>& rates) {
  std::vector<FramePair> out;
  for (const ImageRate& rate : rates) {
    FramePair pair{rate.begin_ns, rate.end_ns, {}};
    for (const CornerPair& corners : pairs_of(frames[rate.first], frames[rate.second]))
      pair.bearings.emplace_back(corners.first->bearing, corners.second->bearing);
    out.push_back(std::move(pair));
  }
  return out;
}

/// What is estimated.
struct Alignment {
  double offset_s;
  SO3 R_imu_cam;
  Vector3 bias;
};

/// Normal equations H d = g of one pair, without its translation.
struct Reduced {
  Matrix7 H = Matrix7::Zero();
  Vector7 g = Vector7::Zero();
};

/// Errors of one pair, at the best translation for a rotation.
class PairErrors {
 public:
  PairErrors(const FramePair& pair, const Matrix3& R_21, double scale) : pair_(pair), scale_(scale) {
    const std::size_t n = pair.bearings.size();
    turned_.reserve(n);
    normals_.reserve(n);
    for (const auto& [f1, f2] : pair.bearings) {
      turned_.emplace_back(R_21 * f1);
      normals_.emplace_back(turned_.back().cross(f2));
    }
    weights_.assign(n, 1);
    norms_.assign(n, 1);
    errors_.assign(n, 0);
    constexpr int rounds = 4;  // weights by the errors, translation by the weights
    for (int round = 0; round < rounds; ++round) find_translation();
  }

  const std::vector<double>& errors() const { return errors_; }

  /// `J` of R_21 <- Exp(psi) R_21 by what is estimated.
  Reduced reduced(const pl::Mat<double, 3, 7>& J_psi) const {
    pl::Mat<double, 5, 5> H = pl::Mat<double, 5, 5>::Zero();
    pl::Vec<double, 5> g = pl::Vec<double, 5>::Zero();
    for (std::size_t i = 0; i < errors_.size(); ++i) {
      pl::Vec<double, 5> J;  // by psi and by the translation
      J.head<3>() = turned_[i].cross(pair_.bearings[i].second.cross(translation_)) / norms_[i];
      J.tail<2>() = across_.transpose() * normals_[i] / norms_[i];
      H.noalias() += weights_[i] * J * J.transpose();
      g -= weights_[i] * errors_[i] * J;
    }
    H.bottomRightCorner<2, 2>() += scale_ * scale_ * pl::Mat<double, 2, 2>::Identity();  // of length 1
    const pl::Mat<double, 2, 3> K = H.bottomRightCorner<2, 2>().inverse() * H.bottomLeftCorner<2, 3>();
    const Matrix3 H_psi = H.topLeftCorner<3, 3>() - H.topRightCorner<3, 2>() * K;
    const Vector3 g_psi = g.head<3>() - K.transpose() * g.tail<2>();
    return {J_psi.transpose() * H_psi * J_psi, J_psi.transpose() * g_psi};
  }

 private:
  void find_translation() {
    Matrix3 N = Matrix3::Zero();
    for (std::size_t i = 0; i < normals_.size(); ++i)
      N.noalias() += weights_[i] / (norms_[i] * norms_[i]) * normals_[i] * normals_[i].transpose();
    Eigen::SelfAdjointEigenSolver<Matrix3> solver;
    solver.compute(N);
    translation_ = solver.eigenvectors().col(0);
    across_ = solver.eigenvectors().rightCols<2>();
    for (std::size_t i = 0; i < normals_.size(); ++i) {
      const Vector3 &p = turned_[i], &f2 = pair_.bearings[i].second;
      const Vector3 by_second = p.cross(translation_), by_first = f2.cross(translation_);
      const double along_second = by_second.dot(f2), along_first = by_first.dot(p);  // bearings keep their length
      norms_[i] = std::sqrt(std::max(
          by_second.squaredNorm() - along_second * along_second + by_first.squaredNorm() - along_first * along_first,
          1e-12));
      errors_[i] = normals_[i].dot(translation_) / norms_[i];
      const double q = errors_[i] / (2 * scale_);
      weights_[i] = 1 / (1 + q * q);
    }
  }

  const FramePair& pair_;
  double scale_;  // noise of one bearing
  Vector3 translation_;
  pl::Mat<double, 3, 2> across_;
  std::vector<Vector3> turned_, normals_;
  std::vector<double> weights_, norms_, errors_;
};

/// Normal equations of all pairs.
struct Sum {
  std::size_t pairs = 0;
  Reduced total;
  Matrix7 clustered = Matrix7::Zero();  // sum g_c g_c^T over the seconds
  double noise = 0;
};

Sum sum_of(const std::vector<FramePair>& pairs, const std::vector<pl::ImuSample>& samples, const Alignment& x,
           double noise) {
  constexpr pl::TimeNs cluster_ns = 1'000'000'000;
  const GyroscopeOrientation gyroscope(samples, x.bias);
  const pl::TimeNs offset_ns = std::llround(1e9 * x.offset_s);
  const Matrix3 R = x.R_imu_cam.matrix();
  Sum out;
  Vector7 cluster = Vector7::Zero();
  std::vector<double> sizes;
  const auto close = [&] {
    out.clustered += cluster * cluster.transpose();
    cluster.setZero();
  };
  pl::TimeNs begin_ns = pairs.empty() ? 0 : pairs.front().first_ns;
  for (const FramePair& pair : pairs) {
    if (!gyroscope.covers(pair.first_ns + offset_ns) || !gyroscope.covers(pair.second_ns + offset_ns)) continue;
    const GyroscopeOrientation::State first = gyroscope.at(pair.first_ns, x.offset_s);
    const GyroscopeOrientation::State second = gyroscope.at(pair.second_ns, x.offset_s);
    const Matrix3 D = first.R.transpose() * second.R, R_21 = R.transpose() * D.transpose() * R;
    const PairErrors errors(pair, R_21, noise);
    pl::Mat<double, 3, 7> J_psi;
    J_psi.col(0) = -R.transpose() * (second.rate - D.transpose() * first.rate);
    J_psi.block<3, 3>(0, 1) = R_21 - Matrix3::Identity();
    J_psi.block<3, 3>(0, 4) = R.transpose() * second.R.transpose() * (second.integral - first.integral);
    const Reduced reduced = errors.reduced(J_psi);
    if (!reduced.g.allFinite()) continue;
    if (pair.first_ns - begin_ns >= cluster_ns) {
      close();
      begin_ns = pair.first_ns;
    }
    out.total.H += reduced.H;
    out.total.g += reduced.g;
    cluster += reduced.g;
    for (const double error : errors.errors()) sizes.push_back(std::abs(error));
    ++out.pairs;
  }
  close();
  out.noise = median(sizes) / 0.6745;  // of a Gaussian
  return out;
}

}  // namespace

std::optional<EpipolarFit> fit_epipolar(const std::vector<TrackedFrame>& frames, const std::vector<ImageRate>& rates,
                                        const std::vector<pl::ImuSample>& samples, const RotationFit& start,
                                        double focal_length_px) {
  constexpr int most_iterations = 30;
  constexpr double converged_s = 2e-5;
  constexpr double first_noise_px = 0.5;  // wide: the start is off
  if (samples.size() < 2) return std::nullopt;
  const std::vector<FramePair> pairs = frame_pairs(frames, rates);
  // What a start may be off by: directions that the motion leaves open stay where they are.
  Vector7 information;
  information << 1 / 0.1, Vector3::Constant(1 / 0.1), Vector3::Constant(1 / 0.1);
  Alignment x{start.time_offset_s, start.R_imu_cam, start.gyro_bias};
  double noise = first_noise_px / focal_length_px;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const Sum sum = sum_of(pairs, samples, x, noise);
    if (sum.pairs < 10 || 10 * sum.pairs < 6 * pairs.size()) return std::nullopt;
    Matrix7 H = sum.total.H;
    H.diagonal() += noise * noise * information.cwiseAbs2();
    const Eigen::LDLT<Matrix7> ldlt(H);
    const Vector7 step = ldlt.solve(sum.total.g);
    if (!step.allFinite() || step.norm() > 1) return std::nullopt;
    x.offset_s += step[0];
    x.R_imu_cam = x.R_imu_cam * SO3::exp(Vector3(step.segment<3>(1)));
    x.bias += step.tail<3>();
    noise = std::max(sum.noise, least_noise_px / focal_length_px);
    if (std::abs(step[0]) > converged_s) continue;
    const Vector7 row = ldlt.solve(Vector7::Unit(0));
    return EpipolarFit{x.offset_s, std::sqrt(row.dot(sum.clustered * row)), x.R_imu_cam, x.bias, noise};
  }
  return std::nullopt;
}
