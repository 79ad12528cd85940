#pragma once
/// A recording in memory, little endian, as pack.cpp writes it:
///
///   RecordingHeader, ImuSample[samples], TimeNs[frames], std::uint8_t[frames][height][width]

#include <cstddef>
#include <cstdint>

#include "plumbline/imu/sample.hpp"
#include "plumbline/sensor/mono.hpp"

struct RecordingHeader {
  static constexpr std::uint64_t expected_magic = 0x31474e49424d4c50;  // "PLMBING1"

  std::uint64_t magic = expected_magic;
  std::int32_t width = 0, height = 0, frames = 0, samples = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;                    ///< pinhole camera without distortion [px]
  double q_body_cam[4] = {}, p_body_cam[3] = {};            ///< extrinsics: quaternion x y z w, position [m]
  double rate_hz = 0, gyro_density = 0, accel_density = 0;  ///< noise of the IMU, as in ImuNoise
  double gyro_walk = 0, accel_walk = 0;
};
static_assert(sizeof(RecordingHeader) == 24 + 16 * 8 && sizeof(plumbline::ImuSample) == 56);

/// A view; the memory must be aligned to 8 bytes.
class Recording {
 public:
  explicit Recording(const void* memory) : header_(static_cast<const RecordingHeader*>(memory)) {}

  bool is_valid() const { return header_->magic == RecordingHeader::expected_magic; }
  const RecordingHeader& header() const { return *header_; }
  int frames() const { return header_->frames; }
  int samples() const { return header_->samples; }
  const plumbline::ImuSample& sample(int i) const {
    return reinterpret_cast<const plumbline::ImuSample*>(header_ + 1)[i];
  }
  template <class Sensors>
  typename Sensors::Frame frame(int i) const {
    const auto* times = reinterpret_cast<const plumbline::TimeNs*>(&sample(samples()));
    const auto* pixels = reinterpret_cast<const std::uint8_t*>(times + frames());
    const int w = header_->width, h = header_->height;
    return {.t_ns = times[i], .gray = {pixels + std::ptrdiff_t(i) * w * h, w, h, w}};
  }

 private:
  const RecordingHeader* header_;
};
