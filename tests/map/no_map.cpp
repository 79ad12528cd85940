// What remembers nothing takes everything and costs nothing.
#include "plumbline/map/no_map.hpp"

#include <string>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"

using namespace plumbline;

namespace {

template <class S>
using MapOf = typename Forgetful::Map<Rig<Rgbd<Pinhole<S>>>>;
static_assert(std::is_same_v<MapOf<float>, NoMap<float>> && std::is_same_v<MapOf<double>, NoMap<double>>);

struct Holder {
  double x;
  [[no_unique_address]] NoMap<double> map;
};
static_assert(std::is_empty_v<NoMap<float>> && sizeof(Holder) == sizeof(double));

}  // namespace

TEMPLATE_TEST_CASE("no_map: the world of the odometry is the map's", "", float, double) {
  NoMap<TestType> map;
  map.retire(1);
  map.retire(std::string("whatever leaves"));
  const SE3<TestType> T_map_odom = map.T_map_odom();
  CHECK(T_map_odom.p().norm() == 0);
  CHECK(T_map_odom.R().isIdentity(0));
}
