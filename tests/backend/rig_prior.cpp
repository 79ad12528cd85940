#include "plumbline/backend/rig_prior.hpp"

#include <cmath>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/state/frame_window.hpp"

using namespace plumbline;

TEST_CASE("rig_prior: extrinsics and time offset are estimated, the time offset unless it is known") {
  for (const bool known : {true, false}) {
    FrameWindow<double, InertialLayout, 3> window;
    window.insert(0, {});
    RigPrior<InertialLayout> prior({}, {});
    CHECK(prior.cost(window) == 0);
    prior.begin(window, SE3<double>(), {0.02, 0, known});
    CHECK(window.estimates_extrinsics());
    CHECK(window.estimates_time_offset() == !known);
    CHECK(prior.cost(window) == 0);
    Vec<double, 3 * 15 + 7> step = Vec<double, 3 * 15 + 7>::Zero();
    step[3 * 15 + 6] = 1e-3;
    window.move(step);
    const double cost = TimeOffsetPrior(TimeOffsetOptions{}, 0).cost(1e-3);
    CHECK(prior.cost(window) == Approx(known ? 0 : cost));
  }
}

namespace {
/// Takes the prior of the extrinsics.
struct Equations {
  Mat<double, 6, 6> H;
  Vec<double, 6> g;
  void add_block(int, int, const Mat<double, 6, 6>& block) { H = block; }
  void add_gradient(int, const Vec<double, 6>& gradient) { g = gradient; }
  void add_extrinsics(const auto& window, const ExtrinsicsPrior& prior) {
    prior.add_to(window.extrinsics().correction(), 0, *this);
  }
  void add_time_offset(const auto&, const TimeOffsetPrior&) {}
};
}  // namespace

TEST_CASE("rig_prior: while the time offset converges the extrinsics are fixed") {
  FrameWindow<double, InertialLayout, 12> window;
  window.insert(9'900'000'000, {});
  RigPrior<InertialLayout> prior({}, {});
  prior.begin(window, SE3<double>(), {0.02, 0, false});
  // A frame later the time offset is corrected by `later_s`.
  const auto is_held = [&](double t_s, double later_s) {
    window.insert(std::llround(1e9 * t_s), {});
    Vec<double, 12 * 15 + 7> step = Vec<double, 12 * 15 + 7>::Zero();
    step[12 * 15 + 6] = later_s;
    window.move(step);
    prior.update_hold(window);
    Equations equations;
    prior.add_to(window, equations);
    return equations.H(0, 0) > 1e9;
  };
  CHECK_FALSE(is_held(10.0, 0));
  CHECK_FALSE(is_held(10.1, 0.002));  // it converges
  CHECK(is_held(10.2, 0.002));
  CHECK(is_held(10.3, 0.010));
  CHECK(is_held(11.2, 0.001));
  CHECK_FALSE(is_held(11.4, 0.001));  // a second after it moved last
  CHECK(is_held(11.5, -0.010));
  // After a reset it has converged.
  window.clear();
  window.insert(11'500'000'000, {});
  prior.begin(window, SE3<double>(), {0.02, 0, false});
  CHECK_FALSE(is_held(11.6, 0));
  // But a time offset that had not converged does so first.
  window.clear();
  window.insert(12'000'000'000, {});
  prior.begin(window, SE3<double>(), {.offset_s = 0.02, .is_known = false, .is_suspect = true});
  CHECK(is_held(12.1, 0));
  CHECK(is_held(12.9, 0));
  CHECK_FALSE(is_held(13.1, 0));
  // A known time offset is no reason.
  window.clear();
  prior.begin(window, SE3<double>(), {0.02, 0, true});
  CHECK_FALSE(is_held(11.7, 0.02));
}

TEST_CASE("rig_prior: a time offset without a sigma is known") {
  FrameWindow<double, InertialLayout, 3> window;
  TimeOffsetOptions exact;
  exact.sigma_s = 0;
  RigPrior<InertialLayout> prior({}, exact);
  prior.begin(window, SE3<double>(), {.is_known = false});
  CHECK_FALSE(window.estimates_time_offset());
}

TEST_CASE("rig_prior: a camera alone has none") {
  STATIC_REQUIRE(sizeof(FrameWindow<double, InertialLayout, 3>) > sizeof(FrameWindow<double, VisualLayout, 3>));
  struct With {
    int a;
    [[no_unique_address]] RigPrior<VisualLayout> prior;
  };
  STATIC_REQUIRE(sizeof(With) <= 2 * sizeof(int));
  STATIC_REQUIRE(std::is_empty_v<RigPrior<VisualLayout>>);
}
