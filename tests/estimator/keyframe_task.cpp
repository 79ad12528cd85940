// Keyframe task beside the caller: the output depends on frames and IMU samples, to the last bit, never on when the
// work was done; nothing that may be asked for meanwhile is written by it (built with the thread sanitizer as well).
#include "allocation_counter.hpp"

#include "plumbline/estimator/keyframe_task.hpp"

#include <algorithm>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "estimator/simulation.hpp"
#include "plumbline/backend/direct_gauss_newton.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/testing/simulated_imu.hpp"
#include "plumbline/thread/background_worker.hpp"

using namespace plumbline;
using test::SimulatedRgbd;

namespace {

enum class When { at_once, at_the_next_wait, on_a_thread };

/// One type, so that one estimator is compiled, for all the moments at which work may run.
class Whenever {
 public:
  static inline When when = When::at_once;
  static inline int started = 0;

  void start(void (*run)(void*), void* context) {
    ++started;
    if (when == When::at_once) run(context);
    if (when == When::on_a_thread) worker_.start(run, context);
    if (when != When::at_the_next_wait) return;
    run_ = run;
    context_ = context;
  }
  void wait() {
    worker_.wait();
    if (void (*const run)(void*) = std::exchange(run_, nullptr)) run(context_);
  }

 private:
  BackgroundWorker worker_;
  void (*run_)(void*) = nullptr;
  void* context_ = nullptr;
};

template <class Inertial>
using Sensors = Rig<Rgbd<Pinhole<double>, SimulatedRgbd::width * SimulatedRgbd::height>, Inertial>;
template <class Inertial, class Backend, class Task>
using Odometer = Estimator<Sensors<Inertial>, Features<Points<150>>, Backend, NoClock, NoMap, Task>;

constexpr int frame_count = 40;
constexpr double first_s = 2;
const SimulatedRgbd& room() {
  static const SimulatedRgbd simulated(frame_count, first_s);
  return simulated;
}
const std::vector<ImuSample>& imu_samples() {
  static const std::vector<ImuSample> all = [] {
    std::vector<ImuSample> out;
    const auto trajectory = *testing::Trajectory::for_scene("room");
    testing::SimulatedImu imu({}, 1);
    for (auto measured = imu.next(trajectory); measured.sample(0).t_ns <= room().t_ns.back();
         measured = imu.next(trajectory)) {
      if (measured.t >= first_s - 0.1) out.push_back(measured.sample(0));
    }
    return out;
  }();
  return all;
}

template <class Vio>
auto make() {
  std::remove_cvref_t<decltype(std::declval<Vio>().rig())> rig{};
  rig.vision.camera = room().camera;
  rig.vision.width = SimulatedRgbd::width;
  rig.vision.height = SimulatedRgbd::height;
  if constexpr (decltype(rig)::has_imu) {
    rig.imu.T_body_cam = testing::simulated_T_body_camera();
    rig.imu.noise = testing::ImuQuality{}.noise;
  }
  return std::make_unique<Vio>(rig);
}

/// Each frame in the same memory, which is overwritten as soon as the call returns; then the IMU samples up to the
/// next.
template <class Vio>
std::vector<Estimate<double>> run(Vio& vio) {
  std::vector<Estimate<double>> out;
  std::size_t next = 0;
  for (std::size_t i = 0; i < frame_count; ++i) {
    for (; next < imu_samples().size() && imu_samples()[next].t_ns <= room().t_ns[i]; ++next) {
      if constexpr (requires { vio.imu(); }) REQUIRE(vio.add_imu(imu_samples()[next]));
    }
    auto frame = room().frames[i];
    const Result<Estimate<double>> estimate = vio.add_frame({room().t_ns[i], frame.gray.view(), frame.depth.view()});
    REQUIRE(estimate);
    REQUIRE(vio.add_frame({room().t_ns[i], frame.gray.view(), frame.depth.view()}).error() == Error::late_sample);
    const auto pixels = frame.depth.view();
    std::fill_n(pixels.data, pixels.width * pixels.height, std::uint16_t(1));
    REQUIRE(vio.latest().T_world_body.p() == estimate->T_world_body.p());
    out.push_back(*estimate);
  }
  return out;
}

/// Relative to the path, of the motion since the first frame that is tracked.
double error_of(const std::vector<Estimate<double>>& estimates, const SE3<double>& T_body_cam) {
  double path = 0, error = 0;
  SE3<double> T_first, T_true_first;
  bool begun = false;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    const SE3<double> T_true = room().T_world_cam[i] * T_body_cam.inverse();
    if (!begun && estimates[i].health.state != HealthState::tracking) continue;
    REQUIRE(estimates[i].health.state == HealthState::tracking);
    if (!begun) {
      begun = true;
      T_first = estimates[i].T_world_body;
      T_true_first = T_true;
      continue;
    }
    path += (room().T_world_cam[i].p() - room().T_world_cam[i - 1].p()).norm();
    const auto moved = T_first.inverse() * estimates[i].T_world_body, truth = T_true_first.inverse() * T_true;
    error = std::max(error, (moved.p() - truth.p()).norm());
  }
  REQUIRE(path > 0.4);
  return error / path;
}

void require_equal(const std::vector<Estimate<double>>& a, const std::vector<Estimate<double>>& b) {
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    CAPTURE(i);
    REQUIRE(a[i].T_world_body.p() == b[i].T_world_body.p());
    REQUIRE(a[i].T_world_body.R() == b[i].T_world_body.R());
    REQUIRE(a[i].v_world_body == b[i].v_world_body);
    REQUIRE(a[i].covariance == b[i].covariance);
    REQUIRE(a[i].keyframe == b[i].keyframe);
    REQUIRE(a[i].tracked == b[i].tracked);
    REQUIRE(a[i].health.state == b[i].health.state);
  }
}

template <class Inertial, class Backend>
void require_same_whenever() {
  using Vio = Odometer<Inertial, Backend, Whenever>;
  const auto run_at = [](When when) {
    Whenever::when = when;
    Whenever::started = 0;
    const auto vio = make<Vio>();
    const std::vector<Estimate<double>> estimates = run(*vio);
    if constexpr (Sensors<Inertial>::has_imu) {
      const typename Vio::Backend& backend = vio->backend();
      REQUIRE(backend.factors().disagreement(backend.window()) > 0);  // that of keyframes is watched
    }
    return estimates;
  };
  const std::vector<Estimate<double>> at_once = run_at(When::at_once);
  REQUIRE(Whenever::started > 4);
  const auto keyframes = std::count_if(at_once.begin(), at_once.end(), [](const auto& x) { return x.keyframe; });
  REQUIRE(keyframes >= Whenever::started);  // those of the start are made in order
  const SE3<double> T_body_cam = Sensors<Inertial>::has_imu ? testing::simulated_T_body_camera() : SE3<double>();
  REQUIRE(error_of(at_once, T_body_cam) < 0.03);
  require_equal(at_once, run_at(When::at_the_next_wait));
  for (int i = 0; i < 3; ++i) require_equal(at_once, run_at(When::on_a_thread));
  require_equal(at_once, run(*make<Odometer<Inertial, Backend, SynchronousExecutor>>()));
}

}  // namespace

TEST_CASE("keyframe_task: a camera alone with a window gives the same whenever the task runs") {
  require_same_whenever<NoImu, SlidingWindow<5>>();
}

TEST_CASE("keyframe_task: camera and IMU with the direct backend give the same whenever the task runs") {
  require_same_whenever<Imu, DirectGaussNewton<5>>();
}

TEST_CASE("keyframe_task: the output is read after the task, the estimator ends after it, and nothing allocates") {
  using Vo = Odometer<NoImu, SlidingWindow<5>, Whenever>;
  Whenever::when = When::on_a_thread;
  Whenever::started = 0;
  const auto vo = make<Vo>();
  for (int started = 0; started < 3;) {
    static std::size_t i = 0;
    Vo::Frame frame{room().t_ns[i], room().frames[i].gray.view(), room().frames[i].depth.view()};
    ++i;
    REQUIRE(test::allocations_of([&] { (void)vo->add_frame(frame), vo->wait(); }) == 0);
    started = Whenever::started;
  }
  REQUIRE(vo->landmarks().get<0>().tracked_count() > 50);
  REQUIRE(vo->backend().window().size() >= 3);
}

TEST_CASE("keyframe_task: the synchronous executor stores no frame") {
  using Vo = Odometer<NoImu, SlidingWindow<5>, SynchronousExecutor>;
  using Parts = Composition<Sensors<NoImu>, Features<Points<150>>, SlidingWindow<5>>;
  using Discard = NoMap::Discard<double>;
  // Two states and a flag, and no copy of images.
  STATIC_REQUIRE(sizeof(KeyframeTask<Parts, Discard, SynchronousExecutor>) <=
                 2 * sizeof(typename Parts::Propagation::State) + 16);
  STATIC_REQUIRE(std::is_trivially_destructible_v<Vo>);
  constexpr std::size_t components =
      sizeof(typename Parts::Sensors) + sizeof(RigState<typename Parts::Sensors>) + sizeof(FrameTracker<Parts>) +
      sizeof(KeyframeWindow<Parts, Discard>) + sizeof(typename Parts::Propagation) + sizeof(Initialization<Parts>) +
      sizeof(Outage<Parts, Discard>) + sizeof(Publisher<double>) + sizeof(Navigation<double, VisualLayout>) +
      sizeof(FrameTiming) + sizeof(KeyframeTask<Parts, Discard, SynchronousExecutor>);
  STATIC_REQUIRE(sizeof(Vo) <= components + 6 * alignof(Vo));  // some counters
  STATIC_REQUIRE(!std::is_copy_constructible_v<Odometer<NoImu, SlidingWindow<5>, BackgroundWorker>>);
}
