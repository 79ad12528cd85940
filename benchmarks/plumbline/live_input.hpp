#pragma once
/// The samples that the messages of a stream hold.                                                  docs/guide/live.md

#include <optional>
#include <vector>

#include "images.hpp"
#include "live_queue.hpp"
#include "plumbline/io/calibration_data.hpp"
#include "stream_message.hpp"

/// The calibration of a message, or one that the message completes: encoding 1 is of the camera, 2 the noise of the
/// IMU. Throws io::ReadError or StreamError.
void read_calibration_message(const Message& message, std::optional<plumbline::io::Calibration>& calibration);

/// One sample or many. Throws StreamError.
std::vector<plumbline::ImuSample> imu_samples_of(const Message& message);

/// Time stamp of a frame or a depth image; its size is checked, and that of its pixels where they are raw. Throws
/// StreamError.
plumbline::TimeNs stamp_of(const Message& message, const plumbline::io::CameraCalibration& camera);

/// Throws std::runtime_error where an image cannot be decoded, or has another size than its message states.
Images images_of(const LiveFrame& frame, double depth_scale);
