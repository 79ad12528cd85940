#include "plumbline/sensor/mono.hpp"

#include <type_traits>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"

using namespace plumbline;

namespace {

using Camera = Pinhole<float>;
constexpr std::size_t pixels = 64 * 64;

/// A camera and the size of its images.
struct Plain {
  Camera camera;
  int width, height;
};

// A global shutter has no readout time, and it is the default.
static_assert(sizeof(Mono<Camera, pixels, Global>) == sizeof(Plain));
static_assert(sizeof(Mono<Camera, pixels, Rolling>) == sizeof(Plain) + sizeof(Readout<float>));
static_assert(std::is_same_v<Mono<Camera>::Shutter, Global>);
static_assert(Mono<Camera, pixels>::max_pixels == pixels && !Mono<Camera>::has_depth);

}  // namespace

TEST_CASE("mono: the readout time is known by default") {
  REQUIRE(Mono<Camera>{}.readout.get().value_s == 0);
  REQUIRE(Mono<Camera>{}.readout.get().sigma_s == 0);
  Mono<Camera, pixels, Rolling> rolling{};
  REQUIRE(rolling.readout.get().sigma_s == 0);
  rolling.readout.set({0.01f, 0.002f});
  REQUIRE(rolling.readout.get().value_s == 0.01f);
}

TEST_CASE("mono: a frame is empty until it is filled") {
  const Mono<Camera>::Frame frame;
  REQUIRE(frame.t_ns == 0);
  REQUIRE(frame.gray.empty());
}
