#include "plumbline/estimator/shutter_motion.hpp"

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/state/rig_state.hpp"
#include "propagation/small_view.hpp"

using namespace plumbline;

namespace {
using RollingRig = Rig<Rgbd<Pinhole<double>, 64 * 64>>;
using GlobalRig = Rig<Mono<Pinhole<double>, 64 * 64>>;

/// A body that turns about the axis of its camera.
struct Turning {
  Vec<double, 3> angular_rate() const { return {0, 0, 2}; }
  Vec<double, 3> velocity(const int&) const { return {0, 0, 0}; }
};
}  // namespace

TEST_CASE("shutter_motion: pixels of a rolling shutter are corrected by the motion of the body") {
  test::SmallView<RollingRig> views;
  const auto& pyramid = *views.pyramid;
  View<RollingRig> view{0, 0.05, views.rig, pyramid, pyramid, {}, {}, {}, {views.rig.vision.camera, 64, 0.02}};
  const Vec<double, 2> pixel(60, 60);
  CHECK((view.shutter.still(pixel, 1).uv - pixel).norm() == 0);
  set_shutter_motion(view, Turning{}, 0, 2.0);
  CHECK((view.shutter.still(pixel, 1).uv - pixel).norm() > 0.3);  // 0.02 s * 2 rad/s * 28 rows of 64 * 40 px
}

TEST_CASE("shutter_motion: with a global shutter no motion is asked for") {
  test::SmallView<GlobalRig> views;
  View<GlobalRig> view = views.at(0, 0.05, {}, {});
  struct {
  } knows_nothing;
  set_shutter_motion(view, knows_nothing, 0, 2.0);
  CHECK((view.shutter.still({60, 60}, 1).uv - Vec<double, 2>(60, 60)).norm() == 0);
}

namespace {
/// A backend whose window finds a readout time.
struct ReadoutBackend {
  using S = double;
  using Sensors = RollingRig;
  using State = int;
  using Factor = int;
  struct Options {};
  struct Landmarks {
    double changed_s = 0;
    void change_readout(double change_s) { changed_s += change_s; }
    void for_each(auto&& visit) { visit(*this); }
  };
  struct Window {
    bool is_full = false;
    bool full() const { return is_full; }
    SE3<double> T_world_body(int) const { return {}; }
    int latest() const { return 0; }
  };

  ReadoutCorrection found{0.01, 1e-3};
  bool is_observable = true;
  int solved = 0;
  double prior_s = -1, sigma_s = -1, in_use_s = -1;
  Window frames;

  Window& window() { return frames; }
  const Window& window() const { return frames; }
  int factors() const { return 0; }
  void set_readout_prior(double value_s, double sigma) { prior_s = value_s, sigma_s = sigma; }
  void set_readout(double value_s) { in_use_s = value_s; }
  bool find_readout(const Sensors&, const SE3<double>&, Landmarks&, ReadoutCorrection& out) {
    ++solved;
    out = found;
    return is_observable;
  }
};
struct Run {
  RollingRig rig{};
  RigState<RollingRig> rig_state;
  ReadoutBackend backend;
  ReadoutBackend::Landmarks landmarks;
  ReadoutEstimation<ReadoutBackend> estimation;

  explicit Run(double sigma_s = 0.02) : rig_state(with(rig, sigma_s), {}) {}
  static RollingRig& with(RollingRig& rig, double sigma_s) {
    rig.vision.readout.set({0.02, sigma_s});
    return rig;
  }
  bool update() {
    struct {
      const RollingRig& rig;
      SE3<double> T_body_cam;
    } const view{rig, {}};
    return estimation.update(backend, view, landmarks, rig_state);
  }
};
}  // namespace

TEST_CASE("shutter_motion: the window begins with the readout time of the calibration, and its sigma") {
  Run run;
  ReadoutEstimation<ReadoutBackend>::start(run.backend, run.rig_state);
  CHECK((run.backend.prior_s == 0.02 && run.backend.sigma_s == 0.02 && run.backend.in_use_s == 0.02));
}

TEST_CASE("shutter_motion: a large correction of the readout time moves all features, and asks for another solution") {
  Run run;
  CHECK(run.update());
  CHECK(run.rig_state.readout().value_s == Approx(0.03));
  CHECK(run.backend.in_use_s == Approx(0.03));
  CHECK(run.landmarks.changed_s == Approx(0.01));
  run.backend.found.value_s = -0.001;
  CHECK_FALSE(run.update());  // small
  CHECK(run.landmarks.changed_s == Approx(0.009));
}

TEST_CASE("shutter_motion: no estimate of a known readout time, of one that is not observable, of each full window") {
  Run known(0);
  CHECK_FALSE(known.update());
  CHECK(known.backend.solved == 0);
  Run run;
  run.backend.is_observable = false;
  CHECK_FALSE(run.update());
  CHECK(run.landmarks.changed_s == 0);
  run.backend.frames.is_full = true;
  run.backend.solved = 0;
  for (int k = 0; k < 9; ++k) run.update();
  CHECK(run.backend.solved == 3);
}
