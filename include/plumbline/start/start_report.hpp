#pragma once
/// How far the start of an estimator has come, or what keeps it.

#include <cstdint>

#include "plumbline/core/time.hpp"
#include "plumbline/imu/alignment.hpp"

namespace plumbline {

enum class InitStage : std::uint8_t {
  few_features,     ///< the images show little that can be tracked
  little_parallax,  ///< a camera without depth must move sideways
  two_views_disagree,
  aligning,      ///< see the alignment's outcome
  not_believed,  ///< aligned, but only with an impossible bias, or contradicted by the readings for long: begun anew
  done,
};

struct InitReport {
  InitStage stage = InitStage::few_features;
  int features = 0;         ///< in sight
  double parallax_rad = 0;  ///< of the two first views
  double inliers = 0;       ///< part of the pairs that fit them
  // Of rigs with an IMU:
  AlignmentOutcome alignment = AlignmentOutcome::too_few_frames;
  double excitation = 0;     ///< [m/s^2]
  double gravity_norm = 0;   ///< as vision and IMU have it before it is fixed [m/s^2]
  double gyro_residual = 0;  ///< rotation of vision against the gyroscope [rad]
  double scale_sigma = 0;    ///< relative
  int rejected = 0;          ///< how often it came to `not_believed`
  TimeNs done_ns = 0;        ///< time of the first estimate
};

constexpr const char* name_of(InitStage stage) {
  switch (stage) {
    case InitStage::few_features: return "few features";
    case InitStage::little_parallax: return "little parallax";
    case InitStage::two_views_disagree: return "two views disagree";
    case InitStage::aligning: return "aligning";
    case InitStage::not_believed: return "not believed";
    case InitStage::done: return "done";
  }
  return "unknown";
}

}  // namespace plumbline
