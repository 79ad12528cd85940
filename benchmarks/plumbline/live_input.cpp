#include "live_input.hpp"

#include <string>

#include "plumbline/io/calibration.hpp"
#include "plumbline/opencv/image_file.hpp"

namespace io = plumbline::io;
namespace pl = plumbline;

namespace {

constexpr std::uint16_t camera_text = 1, imu_text = 2;       // encodings of a calibration
constexpr std::uint16_t raw_pixels = 1, image_file = 2;      // of an image
constexpr std::size_t image_header = 16, imu_size = 56;      // [bytes]
constexpr pl::TimeNs latest_ns = 4'000'000'000'000'000'000;  // differences of two of these are still times

[[noreturn]] void fail_encoding(const Message& message) {
  throw StreamError(message, "encoding " + std::to_string(message.encoding) + " is unknown, read are 1 and 2");
}

std::string size_text(std::uint32_t width, std::uint32_t height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

cv::Mat image_of(const Message& message, int type, double depth_scale) {
  const int width = number_at<std::int32_t>(message.payload, 8), height = number_at<std::int32_t>(message.payload, 12);
  const std::span<const std::uint8_t> pixels = std::span(message.payload).subspan(image_header);
  const std::string name = "stream: " + name_of(message);
  if (message.encoding == raw_pixels) {
    cv::Mat out(height, width, type);
    for (int y = 0, at = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        if (type == CV_8U) {
          out.at<std::uint8_t>(y, x) = pixels[static_cast<std::size_t>(at++)];
        } else {
          const std::size_t i = static_cast<std::size_t>(2 * at++);
          out.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(pixels[i] | pixels[i + 1] << 8);
        }
      }
    return out;
  }
  const auto decode = [&](int flags) { return pl::opencv::decode_image(pixels, flags, name); };
  cv::Mat out = type == CV_8U ? pl::opencv::gray_of(decode, 16) : pl::opencv::depth_of(decode, depth_scale, name);
  pl::opencv::require_resolution(out, width, height, name);
  return out;
}

}  // namespace

void read_calibration_message(const Message& message, std::optional<io::Calibration>& calibration) {
  const std::string name = "stream: " + name_of(message);
  const std::string text(message.payload.begin(), message.payload.end());
  if (message.encoding == camera_text) {
    const std::optional<io::Calibration> before = calibration;
    calibration = io::read_calibration(io::YamlMap(name, text));
    if (before && before->imu && !calibration->imu) calibration->imu = before->imu;
  } else if (message.encoding == imu_text) {
    if (!calibration) throw StreamError(message, "the noise of the IMU comes after the calibration of the camera");
    io::detail::read_imu(io::YamlMap(name, text), *calibration);
  } else {
    fail_encoding(message);
  }
}

std::vector<pl::ImuSample> imu_samples_of(const Message& message) {
  const std::span<const std::uint8_t> bytes = message.payload;
  if (bytes.empty() || bytes.size() % imu_size != 0)
    throw StreamError(message, std::to_string(bytes.size()) + " bytes, expected a multiple of " +
                                   std::to_string(imu_size) + " (t_ns, gyro, accel)");
  std::vector<pl::ImuSample> out;
  for (std::size_t at = 0; at < bytes.size(); at += imu_size) {
    pl::ImuSample sample{number_at<std::int64_t>(bytes, at), {}, {}};
    for (int k = 0; k < 3; ++k) {
      const std::size_t i = at + 8 * static_cast<std::size_t>(k);
      sample.gyro[k] = number_at<double>(bytes, i + 8);
      sample.accel[k] = number_at<double>(bytes, i + 32);
    }
    out.push_back(sample);
  }
  return out;
}

pl::TimeNs stamp_of(const Message& message, const io::CameraCalibration& camera) {
  const std::size_t size = message.payload.size();
  if (size <= image_header)
    throw StreamError(message, std::to_string(size) + " bytes, expected t_ns, width, height and an image");
  if (message.encoding != raw_pixels && message.encoding != image_file) fail_encoding(message);
  const std::uint32_t width = number_at<std::uint32_t>(message.payload, 8),
                      height = number_at<std::uint32_t>(message.payload, 12);
  const std::uint32_t w = static_cast<std::uint32_t>(camera.width), h = static_cast<std::uint32_t>(camera.height);
  if (width != w || height != h)
    throw StreamError(message, "the image is " + size_text(width, height) + ", the calibration has " + size_text(w, h));
  const std::size_t pixels = std::size_t{w} * h * (message.type == MessageType::depth ? 2 : 1);
  if (message.encoding == raw_pixels && size != image_header + pixels)
    throw StreamError(message,
                      std::to_string(size - image_header) + " bytes of pixels, expected " + std::to_string(pixels));
  const pl::TimeNs t_ns = number_at<std::int64_t>(message.payload, 0);
  if (t_ns < -latest_ns || t_ns > latest_ns)
    throw StreamError(message, "impossible time stamp " + std::to_string(t_ns) + " ns");
  return t_ns;
}

Images images_of(const LiveFrame& frame, double depth_scale) {
  Images out{image_of(frame.gray, CV_8U, depth_scale), {}};
  if (frame.depth) out.depth = image_of(*frame.depth, CV_16U, depth_scale);
  return out;
}
