// Frames that the window has no pose for are sought in the map, and where it knows their place they have its pose.
#include "plumbline/estimator/frame_in_map.hpp"

#include <cmath>
#include <memory>
#include <type_traits>
#include <vector>

#include "catch.hpp"
#include "estimator/simulation.hpp"
#include "estimator/small_parts.hpp"
#include "plumbline/estimator/estimator.hpp"

using namespace plumbline;
using test::SimulatedRgbd;
using test::SmallParts;

namespace {

/// A map that knows the true pose of every frame from some time on.
struct Oracle {
  struct Options {
    const SimulatedRgbd* truth = nullptr;
    TimeNs from_ns = 0;
  };
  struct Truth : NoMap::Discard<double> {
    Options options;
    std::vector<TimeNs> asked;
    int resets = 0;
    Truth(const auto& /*rig*/, const Options& o) : options(o) {}
    void on_world_change(const WorldChange<double>& change) {
      resets += change.kind == WorldChange<double>::Kind::reset;
    }
    SO3<double> R_cur_prev;
    bool find_frame(const auto& view, const SO3<double>& R, FoundFrame<double>& found) {
      R_cur_prev = R;
      asked.push_back(view.t_ns);
      if (!options.truth || view.t_ns < options.from_ns) return false;
      const auto& truth = *options.truth;
      for (std::size_t k = 0; k < truth.t_ns.size(); ++k) {
        if (truth.t_ns[k] == view.t_ns) found.T_world_body = truth.T_world_cam[0].inverse() * truth.T_world_cam[k];
      }
      for (int k = 0; k < 6; ++k) found.covariance(k, k) = 1e-4;
      found.inliers = 33;
      return true;
    }
  };
  template <class Parts>
  using Map = Truth;
};

using Found = FrameInMap<SmallParts::Parts, Oracle::Truth>;
using Unasked = FrameInMap<SmallParts::Parts, NoMap::Discard<double>>;
static_assert(SeeksFrames<SmallParts::Parts, Oracle::Truth> && !std::is_empty_v<Found>);
static_assert(!SeeksFrames<SmallParts::Parts, NoMap::Discard<double>> && std::is_empty_v<Unasked>);

using Sensors = Rig<Rgbd<Pinhole<double>, SimulatedRgbd::width * SimulatedRgbd::height>>;
using Vio = Estimator<Sensors, Features<Points<150>>, SlidingWindow<5>, NoClock, Oracle>;

/// Ten frames, then others from elsewhere.
const SimulatedRgbd& joined() {
  static const SimulatedRgbd simulated = [] {
    SimulatedRgbd first(10, 2);
    SimulatedRgbd second(40, 9);
    for (std::size_t k = 0; k < second.frames.size(); ++k) {
      first.frames.push_back(second.frames[k]);
      first.t_ns.push_back(first.t_ns[9] + TimeNs(50'000'000) * TimeNs(k + 1));
      first.T_world_cam.push_back(second.T_world_cam[k]);
    }
    return first;
  }();
  return simulated;
}

std::unique_ptr<Vio> vio_with(const SimulatedRgbd& truth, TimeNs from_ns) {
  Sensors rig{};
  rig.vision.camera = truth.camera;
  rig.vision.width = SimulatedRgbd::width;
  rig.vision.height = SimulatedRgbd::height;
  return std::make_unique<Vio>(rig, Vio::Options{}, Oracle::Options{&truth, from_ns});
}
double error(const SimulatedRgbd& truth, std::size_t k, const Estimate<double>& estimate) {
  return norm(Vec<double, 3>((truth.T_world_cam[0].inverse() * truth.T_world_cam[k]).p() - estimate.T_world_body.p()));
}

}  // namespace

TEST_CASE("frame_in_map: the map is asked once for a frame, and its pose is the frame's") {
  SmallParts parts;
  parts.draw(0);
  const auto view = parts.view(50);
  SimulatedRgbd truth(0);
  truth.t_ns = {0, 50};
  truth.T_world_cam = {SE3<double>(), SE3<double>(SO3<double>(), Vec<double, 3>(1, 2, 3))};
  Oracle::Truth map(0, {&truth, 0});
  Found in_map;
  const SE3<double> predicted(SO3<double>::exp({0, 0, 0.2}), Vec<double, 3>(0, 0, 0));
  REQUIRE(in_map.find(view, map, predicted));
  REQUIRE(in_map.find(view, map, predicted));
  CHECK(map.asked.size() == 1);
  CHECK(norm(Vec<double, 3>(map.R_cur_prev.log() + Vec<double, 3>(0, 0, 0.2))) < 1e-9);
  in_map.apply(parts.navigation, parts.report);
  CHECK(parts.navigation.T_world_body().p() == Vec<double, 3>(1, 2, 3));
  CHECK(parts.navigation.covariance()(3, 3) == 1e-4);
  CHECK(parts.report.reason == HealthReason::map_only);
  CHECK(parts.report.has_metric_pose);
  CHECK(parts.report.is_bridged);
  CHECK(parts.report.tracked == 33);
  CHECK_FALSE(in_map.has_begun_at(50));
  in_map.begin_at(view, parts.window->frames(), parts.navigation);
  CHECK(in_map.has_begun_at(50));
  CHECK_FALSE(in_map.has_begun_at(0));
  CHECK(parts.window->frames().latest().T_world_body.p() == Vec<double, 3>(1, 2, 3));
  CHECK(in_map.distance_from(50) == 0);  // less than its sigma
  truth.t_ns.push_back(55);
  truth.T_world_cam.push_back(SE3<double>(SO3<double>(), Vec<double, 3>(1, 2, 4)));
  REQUIRE(in_map.find(parts.view(55), map, predicted));
  CHECK(in_map.distance_from(50) == Approx(1));
  CHECK(in_map.distance_from(40) == 0);
  map.options.from_ns = 100;
  CHECK(in_map.find(parts.view(55), map, predicted));
  CHECK_FALSE(in_map.find(parts.view(60), map, predicted));
  CHECK(in_map.distance_from(50) == 0);
}

TEST_CASE("frame_in_map: a camera that is carried elsewhere has the poses of the map, and begins there again") {
  const SimulatedRgbd& truth = joined();
  const auto vio = vio_with(truth, 0);
  int by_map = 0;
  std::size_t tracked_again = 0;
  for (std::size_t k = 0; k < truth.frames.size(); ++k) {
    auto frame = truth.frames[k];
    const auto estimate = vio->add_frame({truth.t_ns[k], frame.gray.view(), frame.depth.view()});
    REQUIRE(estimate);
    CHECK(error(truth, k, *estimate) < 0.05);
    CHECK(estimate->health.state != HealthState::lost);
    if (estimate->health.reason == HealthReason::map_only) {
      ++by_map;
      CHECK(estimate->health.state == HealthState::degraded);
      CHECK(estimate->tracked == 33);
      CHECK(std::sqrt(estimate->covariance(3, 3)) < 0.02);
    }
    if (k > 10 && estimate->health.state == HealthState::tracking && tracked_again == 0) tracked_again = k;
  }
  CHECK(by_map > 5);
  CHECK(tracked_again > 10);
  CHECK(vio->map().resets == 2);
  CHECK(vio->latest().health.state == HealthState::tracking);
  for (const TimeNs asked : vio->map().asked) CHECK((asked == truth.t_ns[0] || asked >= truth.t_ns[10]));
}

TEST_CASE("frame_in_map: where the map does not know the place, the frame is lost") {
  const SimulatedRgbd& truth = joined();
  const auto vio = vio_with(truth, TimeNs(1) << 62);
  int lost = 0;
  for (std::size_t k = 0; k < truth.frames.size(); ++k) {
    auto frame = truth.frames[k];
    const auto estimate = vio->add_frame({truth.t_ns[k], frame.gray.view(), frame.depth.view()});
    REQUIRE(estimate);
    CHECK(estimate->health.reason != HealthReason::map_only);
    lost += estimate->health.state == HealthState::lost;
  }
  CHECK(lost > 5);
  CHECK(vio->map().asked.size() > 5);
}
