#include "plumbline/frontend/flow.hpp"

#include <type_traits>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/sensor/mono.hpp"

using namespace plumbline;

namespace {

using Sensors = Rig<Mono<Pinhole<float>, 64 * 64>>;
template <class Entry>
using StoreOf = LandmarkStore<typename Entry::template Kind<Sensors>, Entry::capacity, 3>;
template <class Entry>
using FrontEndOf = Flow::Of<Entry, StoreOf<Entry>>;

struct OwnDetector {
  void detect(const ImageView<const std::uint8_t>&, const auto& /*edges*/, const LineDetectorOptions&, auto& found) {
    found.clear();
  }
};

/// A kind of one's own brings its front end along.
template <class Store>
struct BeaconFinder {};
struct Beacons {
  static constexpr int capacity = 8;
  template <SensorRig S>
  using Kind = PointKind<S>;
  template <class Store>
  using FrontEnd = BeaconFinder<Store>;
};

}  // namespace

TEST_CASE("flow: points by optical flow, lines by their edges, others as they define") {
  STATIC_REQUIRE(std::is_same_v<FrontEndOf<Points<50>>, PointFlow<StoreOf<Points<50>>>>);
  STATIC_REQUIRE(std::is_same_v<FrontEndOf<Points<50, Cauchy>>, PointFlow<StoreOf<Points<50, Cauchy>>>>);
  STATIC_REQUIRE(
      std::is_same_v<FrontEndOf<InitializationPoints<50>>, InitializationFlow<StoreOf<InitializationPoints<50>>>>);
  STATIC_REQUIRE(std::is_same_v<FrontEndOf<Lines<20>>, EdgeFollowing<StoreOf<Lines<20>>>>);
  using Own = Lines<20, OwnDetector>;
  STATIC_REQUIRE(std::is_same_v<FrontEndOf<Own>, EdgeFollowing<StoreOf<Own>, OwnDetector>>);
  STATIC_REQUIRE(std::is_same_v<FrontEndOf<Beacons>, BeaconFinder<StoreOf<Beacons>>>);
}
