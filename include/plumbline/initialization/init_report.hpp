#pragma once
/// Stage of an initialization, with the figures that show what is missing.

#include <cstdint>

#include "plumbline/core/time.hpp"
#include "plumbline/imu/alignment.hpp"

namespace plumbline {

enum class InitStage : std::uint8_t {
  few_features,        ///< the image has too few features
  little_parallax,     ///< the parallax between the two views is too small: a camera without depth must move sideways
  two_views_disagree,  ///< too few feature pairs fit one relative pose
  aligning,            ///< visual poses are being aligned with the IMU, see InitReport::alignment
  rejected,  ///< the initialization was rejected, by an implausible bias or a lasting contradiction, and is repeated
  done,
};

struct InitReport {
  InitStage stage = InitStage::few_features;
  int features = 0;         ///< features in view
  double parallax_rad = 0;  ///< median angle between the rays of the first two views [rad]
  double inliers = 0;       ///< fraction of the feature pairs that fit the two views
  // Rigs with an IMU only:
  AlignmentOutcome alignment = AlignmentOutcome::too_few_frames;
  double excitation = 0;     ///< rms change of the specific force [m/s^2]
  double gravity_norm = 0;   ///< magnitude of gravity by vision and IMU, before it is fixed [m/s^2]
  double gyro_residual = 0;  ///< rotation of vision against the gyroscope, rms [rad]
  double scale_sigma = 0;    ///< relative sigma of the scale
  int rejected = 0;          ///< number of rejected initializations
  TimeNs done_ns = 0;        ///< time of the first metric estimate [ns]
};

constexpr const char* name_of(InitStage stage) {
  switch (stage) {
    case InitStage::few_features: return "few features";
    case InitStage::little_parallax: return "little parallax";
    case InitStage::two_views_disagree: return "two views disagree";
    case InitStage::aligning: return "aligning";
    case InitStage::rejected: return "rejected";
    case InitStage::done: return "done";
  }
  return "unknown";
}

}  // namespace plumbline
