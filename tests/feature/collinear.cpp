#include "plumbline/feature/collinear.hpp"

#include <type_traits>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/mono.hpp"

using namespace plumbline;

namespace {

using Sensors = Rig<Mono<Pinhole<float>>>;
struct OwnDetector {
  void detect(const ImageView<const std::uint8_t>&, const auto& /*edges*/, const LineDetectorOptions&, auto& found) {
    found.clear();
  }
};
using Own = Collinear<15, OwnDetector, Cauchy>;

}  // namespace

TEST_CASE("collinear: an entry of a list of features, with its capacity, detector, kernel and name") {
  STATIC_REQUIRE(Own::capacity == 15);
  STATIC_REQUIRE(std::is_same_v<Own::Detector, OwnDetector>);
  STATIC_REQUIRE(std::is_same_v<Own::Kind<Sensors>, CollinearKind<Sensors, Cauchy>>);
  STATIC_REQUIRE(std::is_same_v<Collinear<60>::Detector, LineSegmentDetector<>>);
  STATIC_REQUIRE(std::is_same_v<Collinear<60>::Kind<Sensors>, CollinearKind<Sensors>>);
  struct Options : Points<180>::Named<int>, Own::Named<double> {
  } options;
  Own::options_of(options) = 0.5;
  Points<180>::options_of(options) = 3;
  CHECK(options.collinear == 0.5);
}

TEST_CASE("collinear: its landmarks consist of points, which precede them in the list") {
  using Kind = Own::Kind<Sensors>;
  STATIC_REQUIRE(HasMembers<Kind>);
  STATIC_REQUIRE(Kind::can_contain<Points<180>::Kind<Sensors>>);
  STATIC_REQUIRE_FALSE(Kind::can_contain<Kind>);
}
