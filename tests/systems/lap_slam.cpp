#include "plumbline/systems/lap_slam.hpp"

#include <Eigen/Geometry>
#include <concepts>
#include <memory>
#include <type_traits>
#include <vector>

#include "../estimator/simulation.hpp"
#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"

using namespace plumbline;

namespace {

constexpr std::size_t max_pixels = test::SimulatedRgbd::width * test::SimulatedRgbd::height;
using Map = KeyframeMap<60, 200, 20, true>;
using Slam = LapSlam<Pinhole<double>, max_pixels, NoClock, Map>;
using Sensors = Rig<Mono<Pinhole<double>, max_pixels>>;

// One line of composition, nothing else; and the parts it must have.
static_assert(
    std::same_as<Slam, Estimator<Sensors, Features<Points<400>, Collinear<100>>, SlidingWindow<10>, NoClock, Map>>);
static_assert(!Sensors::has_depth && !Sensors::has_imu);
static_assert(std::remove_cvref_t<decltype(std::declval<Slam&>().map())>::Core::has_points);

/// Root mean square of the position error after alignment with scale.
double error_of(const std::vector<Vec<double, 3>>& estimated, const std::vector<Vec<double, 3>>& truth) {
  Eigen::Matrix3Xd a(3, Eigen::Index(estimated.size())), b(3, Eigen::Index(truth.size()));
  for (Eigen::Index k = 0; k < a.cols(); ++k) {
    a.col(k) = estimated[std::size_t(k)];
    b.col(k) = truth[std::size_t(k)];
  }
  const Eigen::Matrix4d T = Eigen::umeyama(a, b);
  const Eigen::Matrix3Xd aligned = (T.topLeftCorner<3, 3>() * a).colwise() + T.topRightCorner<3, 1>();
  return std::sqrt((aligned - b).squaredNorm() / double(a.cols()));
}

}  // namespace

TEST_CASE("lap_slam: six seconds in a room, with points and collinear points, and a map that learns and finds again") {
  const test::SimulatedRgbd world(120);
  Sensors sensors{};
  sensors.vision.camera = world.camera;
  sensors.vision.width = world.width;
  sensors.vision.height = world.height;
  const auto slam = std::make_unique<Slam>(sensors, Slam::Options{});
  std::vector<Vec<double, 3>> estimated, corrected, truth;
  for (std::size_t i = 0; i < world.frames.size(); ++i) {
    const Result<Estimate<double>> estimate = slam->add_frame({world.t_ns[i], world.frames[i].gray.view()});
    REQUIRE(estimate);
    if (estimate->health.state != HealthState::tracking) continue;
    estimated.push_back(estimate->T_world_body.p());
    corrected.push_back((slam->map().S_map_world() * Sim3<double>(estimate->T_world_body)).t());
    truth.push_back(world.T_world_cam[i].p());
  }
  REQUIRE(truth.size() > 90);
  CHECK(error_of(estimated, truth) < 0.02);
  CHECK(error_of(corrected, truth) < 0.02);
  std::size_t on_lines = 0;
  slam->landmarks().for_each([&](const auto& store) {
    using Kind = typename std::remove_cvref_t<decltype(store)>::Kind;
    if constexpr (requires { typename Kind::Appearance; }) {
      if constexpr (requires(typename Kind::Appearance a) { a.points; }) on_lines += store.landmarks().size();
    }
  });
  CHECK(on_lines > 3);
  CHECK(slam->map().places().size() > 8);
  CHECK(slam->map().counts().recalled > 0);
}
