#include "plumbline/feature/view.hpp"

#include <array>
#include <memory>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;

namespace {

using Camera = Pinhole<float>;
template <class Shutter>
using RigOf = Rig<Mono<Camera, 64 * 48, Shutter>>;

// The pyramid of a rig is as large as the rig's images, and a view has the shutter of its rig.
static_assert(std::is_same_v<RigPyramid<RigOf<Global>>, Pyramid<4, 64 * 48>>);
static_assert(std::is_same_v<decltype(View<RigOf<Global>>::shutter), GlobalShutter<Camera>>);
static_assert(std::is_same_v<decltype(View<RigOf<Rolling>>::shutter), RollingShutter<Camera>>);
static_assert(sizeof(View<RigOf<Global>>) < sizeof(View<RigOf<Rolling>>));

}  // namespace

TEST_CASE("view: gives what a front end needs by reference") {
  const RigOf<Rolling> rig{};
  const auto pyramids = std::make_unique<std::array<RigPyramid<RigOf<Rolling>>, 2>>();
  const View<RigOf<Rolling>> view{
      5, 0.1f, rig, (*pyramids)[0], (*pyramids)[1], {}, {}, {}, {rig.vision.camera, 48, 0.02f}};
  REQUIRE(&view.camera() == &rig.vision.camera);
  REQUIRE(&view.previous == &(*pyramids)[0]);
  REQUIRE(&view.current == &(*pyramids)[1]);
  REQUIRE(view.depth.empty());
}
