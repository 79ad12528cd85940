// A thousand damaged bags: each is read or refused, without a crash, a hang or an allocation that its size does not ask
// for.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <new>
#include <random>
#include <string>
#include <vector>

#include <opencv2/imgcodecs.hpp>

#include "bag_writer.hpp"
#include "catch.hpp"
#include "plumbline/io/bag/bag_recording.hpp"
#include "temporary_directory.hpp"

namespace {

std::atomic<std::size_t> largest_allocation{0};

void* allocate(std::size_t size) {
  std::size_t largest = largest_allocation;
  while (size > largest && !largest_allocation.compare_exchange_weak(largest, size)) {
  }
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t size) { return allocate(size); }
void* operator new[](std::size_t size) { return allocate(size); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return std::malloc(size); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

using namespace plumbline::io;

namespace {

std::string png() {
  cv::Mat image(test::height, test::width, CV_8U);
  cv::randu(image, 0, 255);
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", image, bytes);
  return {bytes.begin(), bytes.end()};
}

std::string damaged(std::string bytes, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  const std::size_t kind = below(4);
  if (kind == 0) return bytes.substr(0, below(bytes.size()));
  if (kind == 1) {  // a size that is too large
    for (std::size_t i = below(bytes.size()), n = std::min(bytes.size(), i + 4); i < n; ++i) bytes[i] = '\xFF';
    return bytes;
  }
  for (std::size_t n = 1 + below(8); n > 0; --n) {
    char& byte = bytes[kind == 2 ? below(bytes.size()) : below(std::min<std::size_t>(bytes.size(), 1500))];
    byte = static_cast<char>(byte ^ 1 << below(8));
  }
  return bytes;
}

// Whether anything could be read.
bool read_all(const std::filesystem::path& file) {
  try {
    const Recording recording =
        bag::open_recording(file, {.image = "/cam/image_raw", .depth = {}, .imu = {}, .camera_info = {}}, {});
    for (const FrameSample& frame : recording.frames()) {
      try {
        read_gray(frame);
        if (frame.depth) read_depth(frame);
      } catch (const std::runtime_error&) {
        continue;
      }
    }
    return true;
  } catch (const std::runtime_error& error) {
    REQUIRE(std::string(error.what()).find('\n') == std::string::npos);
    return false;
  }
}

}  // namespace

TEST_CASE("a thousand damaged bags are read or refused") {
  const TemporaryDirectory directory;
  const auto file = directory.path() / "damaged";
  std::mt19937 random(7);
  const std::string picture = png();
  int bags = 0, read = 0;
  for (const test::BagFormat& format : test::bag_formats) {
    auto messages = test::robot_messages(format.serialization);
    for (int i = 0; i < 4; ++i)
      messages.push_back({0, "/cam/compressed", "CompressedImage",
                          test::compressed_message(format.serialization, test::frame_ns(i), "mono8; png", picture)});
    test::write_bag(file, format, messages);
    const std::string bytes = test::bytes_of(file);
    for (int i = 0; i < 143; ++i, ++bags) {
      CAPTURE(format.name, format.compression, i);
      test::write_bytes(file, damaged(bytes, random));
      const auto begin = std::chrono::steady_clock::now();
      read += read_all(file);
      REQUIRE(std::chrono::steady_clock::now() - begin < std::chrono::seconds(10));
    }
  }
  REQUIRE(bags >= 1000);
  REQUIRE(read > bags / 5);
  REQUIRE(read < bags);
  REQUIRE(largest_allocation < 32U << 20);
}
