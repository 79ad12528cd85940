#include "plumbline/state/frame_window.hpp"

#include "catch.hpp"
#include "plumbline/lie/plus.hpp"

using namespace plumbline;

namespace {

using Window = FrameWindow<double, VisualLayout, 3>;

SE3<double> pose(double x) { return {SO3<double>::exp({0.1 * x, 0.2, -0.1}), Vec<double, 3>(x, 0.5, 1)}; }

}  // namespace

TEST_CASE("frame_window: slots are kept, freed and used again") {
  Window window;
  REQUIRE(window.insert(1, {}) == 0);
  REQUIRE(window.insert(2, {}) == 1);
  REQUIRE(window.insert(3, {}) == 2);
  REQUIRE(window.full());
  REQUIRE(window.newest() == 2);
  REQUIRE(window.oldest() == 0);
  window.remove(1);
  REQUIRE_FALSE(window[1].used);
  REQUIRE(window.insert(4, {}) == 1);
  REQUIRE(window.newest() == 1);
  REQUIRE(window[1].sequence > window[2].sequence);
  REQUIRE(window[1].t_ns == 4);
  window.clear();
  REQUIRE(window.size() == 0);
}

TEST_CASE("frame_window: older and newer go by the order of insertion, not by slots") {
  Window window;
  for (int k = 0; k < 3; ++k) window.insert(k, {});
  window.remove(0);
  window.insert(3, {});  // into slot 0; the order is 1, 2, 0
  REQUIRE(window.newest() == 0);
  REQUIRE(window.oldest() == 1);
  REQUIRE(window.before(window[0].sequence) == 2);
  REQUIRE(window.before(window[2].sequence) == 1);
  REQUIRE(window.before(window[1].sequence) == -1);
  window.remove(0);
  REQUIRE(window.newest() == 2);
  window.remove(1);
  REQUIRE(window.newest() == 2);
  REQUIRE(window.oldest() == 2);
}

TEMPLATE_TEST_CASE("frame_window: the first estimate of a new pose has the relative pose of the estimates", "", float,
                   double) {
  using S = TestType;
  const S tolerance = std::is_same_v<S, float> ? S(2e-6) : S(1e-12);
  FrameWindow<S, VisualLayout, 3> window;
  const SE3<S> T_0 = pose(0).cast<S>(), T_1 = pose(1).cast<S>();
  const auto first = [&](int slot) { return window[slot].state.template get<state::Pose>().first_estimate(); };
  window.insert(1, {T_0});
  REQUIRE(minus(first(0), T_0).norm() == 0);
  window.state(0).fix_first_estimates();
  window.state(0).add(Vec<S, 6>::Constant(S(0.1)));
  window.insert(2, {T_1});
  REQUIRE(minus(window.T_world_body(1), T_1).norm() == 0);
  const SE3<S> relative = window.T_world_body(0).inverse() * T_1;
  REQUIRE(minus(first(0).inverse() * first(1), relative).norm() < tolerance);  // (3)
  REQUIRE(minus(first(1), T_1).norm() > S(0.05));
  const Vec<S, 6> e = window[1].state.correction();
  REQUIRE(minus(plus(first(1), e), T_1).norm() < 2 * tolerance);
}

TEMPLATE_TEST_CASE("frame_window: a pose without a prior keeps that relative pose in every step", "", float, double) {
  using S = TestType;
  const S tolerance = std::is_same_v<S, float> ? S(4e-6) : S(1e-12);
  FrameWindow<S, VisualLayout, 4> window;
  for (int k = 0; k < 4; ++k) window.insert(k, {pose(k).cast<S>()});
  const auto first = [&](int slot) { return window[slot].state.template get<state::Pose>().first_estimate(); };
  const auto require_related = [&](int slot, int known) {
    const SE3<S> relative = window.T_world_body(known).inverse() * window.T_world_body(slot);
    CHECK(minus(first(known).inverse() * first(slot), relative).norm() < tolerance);  // (3)
  };
  Vec<double, 4 * 6> step;
  for (int k = 0; k < step.size(); ++k) step[k] = 0.01 * (k + 1);
  window.move(step);
  for (int k = 0; k < 4; ++k) CHECK(minus(first(k), window.T_world_body(k)).norm() == 0);  // no prior refers to any

  window.state(0).fix_first_estimates();
  window.state(2).fix_first_estimates();
  const SE3<S> first_0 = first(0), first_2 = first(2);
  for (int n = 0; n < 3; ++n) {
    window.move(step);
    require_related(1, 2);
    require_related(3, 2);
    const Vec<S, 6> e = window[3].state.correction();
    CHECK(minus(plus(first(3), e), window.T_world_body(3)).norm() < 2 * tolerance);
  }
  CHECK(minus(first(0), first_0).norm() == 0);
  CHECK(minus(first(2), first_2).norm() == 0);
  window.remove(2);
  window.move(step);
  require_related(1, 0);
  require_related(3, 0);
}

TEMPLATE_TEST_CASE("frame_window: in another world corrections and relative poses are the same", "", float, double) {
  using S = TestType;
  const S tolerance = std::is_same_v<S, float> ? S(4e-6) : S(1e-12);
  FrameWindow<S, VisualLayout, 3> window;
  window.insert(1, {pose(0).cast<S>()});
  window.state(0).fix_first_estimates();
  window.state(0).add(Vec<S, 6>::Constant(S(0.1)));
  window.insert(2, {pose(1).cast<S>()});
  const FrameWindow<S, VisualLayout, 3> before = window;
  const SE3<S> G = pose(2).cast<S>();
  window.transform(G);
  for (int k = 0; k < 2; ++k) {
    REQUIRE(minus(window.T_world_body(k), G * before.T_world_body(k)).norm() < tolerance);
    REQUIRE(window[k].state.correction() == before[k].state.correction());
    const auto& pose_k = window[k].state.template get<state::Pose>();
    REQUIRE(minus(plus(pose_k.first_estimate(), pose_k.correction()), pose_k.value()).norm() < tolerance);
  }
  window.state(0).add(Vec<S, 6>::Constant(S(0.01)));  // the next step is the same, too
  FrameWindow<S, VisualLayout, 3> moved = before;
  moved.state(0).add(Vec<S, 6>::Constant(S(0.01)));
  REQUIRE(minus(window.T_world_body(0), G * moved.T_world_body(0)).norm() < tolerance);
}

TEST_CASE("frame_window: only poses take over how far the window has moved") {
  FrameWindow<double, InertialLayout, 3> window;
  NavState<double> x;
  x.v_world_body << 1, 0, 0;
  window.insert(1, x);
  window.state(0).fix_first_estimates();
  window.state(0).add(Vec<double, 15>::Constant(0.1));
  window.insert(2, x);
  REQUIRE(window[1].state.get<state::Velocity>().correction().norm() == 0);
  REQUIRE(window[1].state.get<state::Pose>().correction().norm() > 0.1);
}

TEST_CASE("frame_window: the latest frame is one of the window, or separate") {
  Window window;
  window.set_latest({pose(5)});
  REQUIRE(window.latest().T_world_body.p().x() == 5);
  const int slot = window.insert(1, {pose(1)}), other = window.insert(2, {pose(2)});
  REQUIRE(window.latest().T_world_body.p().x() == 5);
  window.set_latest(slot);
  REQUIRE(window.latest().T_world_body.p().x() == 1);
  window.state(slot).add((Vec<double, 6>() << 0, 0, 0, 0.5, 0, 0).finished());
  REQUIRE(minus(window.latest().T_world_body, window.T_world_body(slot)).norm() == 0);  // moves with the window

  const SE3<double> T = window.T_world_body(slot);
  window.remove(slot);  // and stays when its slot is freed
  REQUIRE(minus(window.latest().T_world_body, T).norm() == 0);
  REQUIRE(window.insert(3, {pose(3)}) == slot);
  REQUIRE(minus(window.latest().T_world_body, T).norm() == 0);
  window.set_latest(other);
  window.clear();
  REQUIRE(window.latest().T_world_body.p().x() == 2);
}

TEST_CASE("frame_window: a step moves every frame that is there, and the rig while that is estimated") {
  FrameWindow<double, InertialLayout, 3> window;
  for (int k = 0; k < 3; ++k) window.insert(k, {pose(k)});
  window.remove(1);
  Vec<double, 3 * 15 + 7> step;
  for (int k = 0; k < step.size(); ++k) step[k] = 0.01 * (k + 1);
  const SE3<double> given = pose(4);
  window.move(step);
  for (const int k : {0, 2}) {
    CHECK(minus(window.T_world_body(k), plus(pose(k), Vec<double, 6>(step.segment<6>(15 * k)))).norm() < 1e-12);
    CHECK((window[k].state.value().bias_accel - step.segment<3>(15 * k + 12)).norm() < 1e-15);
  }
  CHECK_FALSE(window.estimates_extrinsics());
  CHECK(minus(window.T_body_cam(given), given).norm() == 0);
  CHECK(window.time_offset_s(0.3) == 0.3);

  window.estimate_extrinsics(pose(5));
  CHECK(minus(window.T_body_cam(given), pose(5)).norm() == 0);
  window.move(step);
  const Vec<double, 6> e = step.segment<6>(3 * 15);
  CHECK(minus(window.T_body_cam(given), plus(pose(5), e)).norm() < 1e-12);
  CHECK((window.extrinsics().correction() - e).norm() == 0);
  CHECK(minus(window.extrinsics().first_estimate(), pose(5)).norm() == 0);

  CHECK_FALSE(window.estimates_time_offset());
  window.estimate_time_offset(-0.05);
  CHECK(window.time_offset_s(0.3) == -0.05);
  window.move(step);
  CHECK(window.time_offset().correction()[0] == step[3 * 15 + 6]);
  CHECK(window.time_offset_s(0.3) == -0.05 + step[3 * 15 + 6]);
  CHECK(window.time_offset().first_estimate()[0] == -0.05);
  CHECK((window.extrinsics().correction() - 2 * e).norm() < 1e-15);
  window.clear();
  CHECK(minus(window.T_body_cam(given), given).norm() == 0);
  CHECK(window.time_offset_s(0.3) == 0.3);
}
