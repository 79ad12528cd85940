#pragma once
/// What an estimator with an IMU gathers before it knows scale, gravity, velocity and biases, and what it is missing.
///                                                                                docs/math/inertial_window.md

#include <array>
#include <cstdint>
#include <span>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/geometry/two_view.hpp"
#include "plumbline/imu/alignment.hpp"
#include "plumbline/imu/preintegration.hpp"

namespace plumbline {

struct InertialStartOptions {
  double frame_interval_s = 0.1;    ///< between the poses that are aligned with the IMU
  double min_parallax_rad = 0.035;  ///< of the two first views of a camera without depth
  double min_inliers = 0.7;         ///< of the pairs, that fit the two views
  int min_pairs = 30;
  double max_start_s = 4;             ///< longer without a second view: begin with a new first one
  double max_accel_bias_sigmas = 10;  ///< of start_accel_bias_sigma, when images and readings are first solved together
  TwoViewOptions two_view;
  InertialAlignmentOptions alignment;
};

/// How far the start has come, or what keeps it.
enum class InitStage : std::uint8_t {
  few_features,     ///< the images show little that can be tracked
  little_parallax,  ///< a camera without depth must move sideways
  two_views_disagree,
  aligning,      ///< see the alignment's outcome
  not_believed,  ///< aligned, but all images and readings together need an impossible bias: begun anew
  done,
};

struct InitReport {
  InitStage stage = InitStage::few_features;
  AlignmentOutcome alignment = AlignmentOutcome::too_few_frames;
  int features = 0;          ///< in sight
  double parallax_rad = 0;   ///< of the two first views
  double inliers = 0;        ///< part of the pairs that fit them
  double excitation = 0;     ///< [m/s^2]
  double gravity_norm = 0;   ///< as vision and IMU have it before it is fixed [m/s^2]
  double gyro_residual = 0;  ///< rotation of vision against the gyroscope [rad]
  double scale_sigma = 0;    ///< relative
  int rejected = 0;          ///< how often it came to `not_believed`
  TimeNs done_ns = 0;        ///< time of the first inertial estimate
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

/// The newest camera poses at regular intervals, with the IMU's increments between them.
template <class S>
class AlignmentWindow {
 public:
  static constexpr int capacity = 24;
  using Increment = Preintegration<S, 64>;
  using Outcome = InertialAlignment<S, capacity>;

  void clear() { frames_.clear(); }

  /// One frame, with the readings since the one before. True when it became one of the poses.
  template <std::size_t N>
  bool add(const SE3<S>& T_ref_cam, const Preintegration<S, N>& since_last, double interval_s) {
    if (frames_.empty()) {
      frames_.push_back({T_ref_cam, Increment(since_last.noise())});
      pending_ = Increment(since_last.noise());
      return true;
    }
    for (const ImuInterval<S>& interval : since_last.intervals()) pending_.add(interval);
    if (pending_.increment().duration < S(interval_s)) return false;
    if (frames_.full()) {
      for (std::size_t i = 1; i < frames_.size(); ++i) frames_[i - 1] = frames_[i];
      frames_.resize(frames_.size() - 1);
    }
    frames_.push_back({T_ref_cam, pending_});
    pending_ = Increment(since_last.noise());
    return true;
  }

  Outcome align(const SE3<S>& T_body_cam, const InertialAlignmentOptions& options) {
    std::array<AlignmentFrame<Increment>, capacity> frames;
    for (std::size_t i = 0; i < frames_.size(); ++i) frames[i] = {frames_[i].T_ref_cam, &frames_[i].increment};
    return align_inertial<capacity, Increment>(
        std::span<const AlignmentFrame<Increment>>(frames.data(), frames_.size()), T_body_cam, options);
  }

 private:
  struct Entry {
    SE3<S> T_ref_cam;
    Increment increment;
  };

  FixedVector<Entry, capacity> frames_;
  Increment pending_;
};

}  // namespace plumbline
