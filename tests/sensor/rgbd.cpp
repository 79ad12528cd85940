#include "plumbline/sensor/rgbd.hpp"

#include <type_traits>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/sensor/mono.hpp"

using namespace plumbline;

namespace {

using Camera = Pinhole<float>;
constexpr std::size_t pixels = 64 * 64;

// More than a gray camera by its depth sensor; most of them roll.
static_assert(sizeof(Rgbd<Camera, pixels, Global>) ==
              sizeof(Mono<Camera, pixels, Global>) + sizeof(DepthSensor<float>));
static_assert(sizeof(Rgbd<Camera, pixels, Rolling>) == sizeof(Rgbd<Camera, pixels, Global>) + sizeof(Readout<float>));
static_assert(std::is_same_v<Rgbd<Camera>::Shutter, Rolling>);
static_assert(Rgbd<Camera, pixels>::max_pixels == pixels && Rgbd<Camera>::has_depth);

}  // namespace

TEST_CASE("rgbd: the readout time is estimated for a rolling shutter") {
  REQUIRE(Rgbd<Camera>{}.readout.get().value_s == 0);
  REQUIRE(Rgbd<Camera>{}.readout.get().sigma_s > 0);
  REQUIRE(Rgbd<Camera, pixels, Global>{}.readout.get().sigma_s == 0);
}

TEST_CASE("rgbd: a frame may come without depth") {
  const Rgbd<Camera>::Frame frame;
  REQUIRE(frame.gray.empty());
  REQUIRE(frame.depth.empty());
}
