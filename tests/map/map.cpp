// What an estimator tells its map: the order of events, their identities and their units.
#include "plumbline/map/map.hpp"

#include <algorithm>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "estimator/simulation.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/testing/simulated_imu.hpp"

using namespace plumbline;
using test::SimulatedRgbd;
using Change = WorldChange<double>::Kind;

namespace {

struct Event {
  enum class Type { keyframe, retired, change } type;
  std::uint32_t sequence = 0;
  TimeNs t_ns = 0;
  SE3<double> T_world_body;
  int observations = 0;
  Change change = Change::reset;
  Sim3<double> S_new_old = {};
};

/// Keeps every event.
struct Recording {
  struct Options {};
  struct Recorder {
    std::vector<Event> events;
    Recorder(const auto& /*rig*/, const auto& /*options*/) {}
    void on_keyframe(const auto& keyframe) {
      REQUIRE(keyframe.image.level(0).width == SimulatedRgbd::width);
      int observations = 0;
      keyframe.for_each_observation(
          [&](const auto& landmark, const auto&) { observations += landmark.id < 1'000'000; });
      events.push_back(
          {Event::Type::keyframe, keyframe.sequence, keyframe.t_ns, keyframe.x.T_world_body, observations});
    }
    void on_retired(const auto& retired) {
      events.push_back({Event::Type::retired, retired.sequence, retired.t_ns, retired.x.T_world_body});
    }
    void on_world_change(const WorldChange<double>& change) {
      events.push_back({Event::Type::change, 0, 0, {}, 0, change.kind, change.S_new_old});
    }
    static void work() {}
    static Sim3<double> S_map_world() { return {}; }
  };
  template <class Parts>
  using Map = Recorder;
};

template <class Inertial>
using Vio = Estimator<Rig<Rgbd<Pinhole<double>, SimulatedRgbd::width * SimulatedRgbd::height>, Inertial>,
                      Features<Points<150>>, SlidingWindow<5>, NoClock, Recording>;

constexpr int frame_count = 60;
const SimulatedRgbd& room() {
  static const SimulatedRgbd simulated(frame_count);
  return simulated;
}

/// The run so far, with a reset asked for before frame `reset_at`.
template <class Inertial>
struct Run {
  std::unique_ptr<Vio<Inertial>> vio;
  std::vector<Estimate<double>> estimates;

  explicit Run(int reset_at = -1) {
    std::remove_cvref_t<decltype(vio->rig())> rig{};
    rig.vision.camera = room().camera;
    rig.vision.width = SimulatedRgbd::width;
    rig.vision.height = SimulatedRgbd::height;
    if constexpr (decltype(rig)::has_imu) {
      rig.imu.T_body_cam = testing::simulated_T_body_camera();
      rig.imu.noise = testing::ImuQuality{}.noise;
    }
    vio = std::make_unique<Vio<Inertial>>(rig);
    const auto trajectory = *testing::Trajectory::for_scene("room");
    testing::SimulatedImu imu({}, 1);
    auto measured = imu.next(trajectory);
    for (int i = 0; i < frame_count; ++i) {
      const TimeNs t_ns = room().t_ns[std::size_t(i)];
      if constexpr (decltype(rig)::has_imu) {
        for (; measured.sample(0).t_ns <= t_ns; measured = imu.next(trajectory)) (void)vio->add_imu(measured.sample(0));
      }
      if (i == reset_at) vio->request_reset();
      auto frame = room().frames[std::size_t(i)];
      const auto estimate = vio->add_frame({t_ns, frame.gray.view(), frame.depth.view()});
      REQUIRE(estimate);
      estimates.push_back(*estimate);
    }
  }
  const std::vector<Event>& events() const { return vio->map().events; }
  int count(Change change) const {
    return int(std::count_if(events().begin(), events().end(), [&](const Event& event) {
      return event.type == Event::Type::change && event.change == change;
    }));
  }

  /// Keyframes are adopted in order of sequence, once, and are retired after that, once.
  void require_order() const {
    std::vector<std::uint32_t> adopted, retired;
    for (const Event& event : events()) {
      if (event.type == Event::Type::keyframe) {
        CHECK((adopted.empty() || event.sequence > adopted.back()));
        CHECK(event.observations > 20);
        adopted.push_back(event.sequence);
      } else if (event.type == Event::Type::retired) {
        CHECK(std::count(adopted.begin(), adopted.end(), event.sequence) == 1);
        CHECK(std::count(retired.begin(), retired.end(), event.sequence) == 0);
        retired.push_back(event.sequence);
      }
    }
    CHECK(adopted.size() > 3);
  }
};

}  // namespace

TEST_CASE("map: keyframes are adopted and retired, each once, and a reset hands the window over first") {
  constexpr int reset_at = 40;
  const Run<NoImu> run(reset_at);
  run.require_order();
  CHECK(run.count(Change::transformed) == 0);
  CHECK(run.count(Change::rejected) == 0);
  REQUIRE(run.count(Change::reset) == 2);  // the first window is cleared as well, when it is empty
  CHECK(run.estimates.back().resets == 1);
  const auto& events = run.events();
  REQUIRE(events.front().type == Event::Type::change);
  std::size_t at = 1;
  while (events[at].type != Event::Type::change) ++at;
  std::vector<std::uint32_t> before, handed;
  for (std::size_t k = 1; k < at; ++k) {
    (events[k].type == Event::Type::keyframe ? before : handed).push_back(events[k].sequence);
  }
  std::sort(handed.begin(), handed.end());
  CHECK(handed == before);  // all that was learned was retired
  CHECK(events[at + 1].type == Event::Type::keyframe);
  // The new world continues at the pose of the old one.
  const SE3<double>& T_before = run.estimates[reset_at - 1].T_world_body;
  CHECK((events[at + 1].T_world_body.p() - T_before.p()).norm() < 0.2);
}

TEST_CASE("map: with an IMU the world is turned upright once, and poses before and after are related by that") {
  const Run<Imu> run;
  run.require_order();
  REQUIRE(run.estimates.back().health.state == HealthState::tracking);
  REQUIRE(run.count(Change::transformed) == 1);
  const auto& events = run.events();
  const auto change = std::find_if(events.begin(), events.end(), [](const Event& event) {
    return event.type == Event::Type::change && event.change == Change::transformed;
  });
  CHECK(change->S_new_old.scale() == Approx(1));  // depth is metric
  // The same keyframe, adopted before and retired after: its camera is mapped by the similarity.
  const SE3<double> T_body_cam = testing::simulated_T_body_camera();
  const SE3<double> rotated(T_body_cam.rotation(), zeros<double, 3>());  // the body of vision is its camera
  int compared = 0;
  for (auto adopted = events.begin(); adopted != change; ++adopted) {
    if (adopted->type != Event::Type::keyframe) continue;
    const auto retired = std::find_if(change, events.end(), [&](const Event& event) {
      return event.type == Event::Type::retired && event.sequence == adopted->sequence;
    });
    if (retired == events.end()) continue;
    const SE3<double> T_old = adopted->T_world_body * rotated, T_new = retired->T_world_body * T_body_cam;
    CHECK((change->S_new_old * T_old.p() - T_new.p()).norm() < 0.02);
    CHECK(((change->S_new_old.rotation() * T_old.rotation()).inverse() * T_new.rotation()).log().norm() < 0.02);
    ++compared;
  }
  CHECK(compared > 0);
}
