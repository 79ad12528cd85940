#include "plumbline/feature/lines.hpp"

#include <type_traits>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/sensor/mono.hpp"

using namespace plumbline;

namespace {

struct FindsNothing {
  void detect(const ImageView<const std::uint8_t>&, const auto& /*edges*/, const LineDetectorOptions&, auto& found) {
    found.clear();
  }
};

}  // namespace

TEST_CASE("lines: capacity, detector, kind and kernel are part of the type, options have a name") {
  using Sensors = Rig<Mono<Pinhole<float>>>;
  using Own = Lines<20, FindsNothing, Cauchy>;
  STATIC_REQUIRE(Own::capacity == 20);
  STATIC_REQUIRE(std::is_same_v<Own::Detector, FindsNothing>);
  STATIC_REQUIRE(std::is_same_v<Lines<20>::Detector, LineSegmentDetector<>>);
  STATIC_REQUIRE(std::is_same_v<Lines<20>::Kind<Sensors>, LineKind<Sensors>>);
  STATIC_REQUIRE(std::is_same_v<Own::Kind<Sensors>, LineKind<Sensors, Cauchy>>);
  struct : Own::Named<int> {
  } options;
  options.lines = 7;
  REQUIRE(&Own::options_of(options) == &options.lines);
}
