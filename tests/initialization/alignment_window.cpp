#include "plumbline/initialization/alignment_window.hpp"

#include <type_traits>

#include "catch.hpp"
#include "imu/simulated_alignment.hpp"

using namespace plumbline;

namespace {

constexpr double step_s = 0.2;  // between the frames of a SimulatedAlignment

template <class S>
InertialAlignmentOptions exact_poses() {
  InertialAlignmentOptions options;
  options.rotation_sigma = 0;
  options.position_sigma = std::is_same_v<S, float> ? 1e-5 : 1e-6;
  options.accel_bias_sigma = 100;
  options.max_scale_sigma = 0.5;
  return options;
}

}  // namespace

TEMPLATE_TEST_CASE("alignment_window: frames closer than the interval are joined", "", float, double) {
  using S = TestType;
  const test::SimulatedAlignment<S> s(1, 1.5, {0.02, -0.01, 0.05}, {0.1, 0.2, -0.15}, 17);
  for (const int joined : {1, 2}) {
    CAPTURE(joined);
    AlignmentWindow<S> window;
    for (std::size_t k = 0; k < s.frames.size(); ++k) {
      const bool is_pose = window.add(TimeNs(k), s.frames[k].T_ref_cam, s.imu[k], (joined - 0.1) * step_s);
      REQUIRE(is_pose == (int(k) % joined == 0));
    }
    const auto found = window.align(s.T_body_cam.template cast<S>(), exact_poses<S>(), standard_gravity<double>);
    CAPTURE(name_of(found.outcome));
    REQUIRE(found);
    REQUIRE(found.v_world_body.size() == (joined == 1 ? 17 : 9));
    REQUIRE(double(found.scale) == Approx(1.5).epsilon(std::is_same_v<S, float> ? 1e-2 : 1e-3));
    REQUIRE((found.bias_gyro.template cast<double>() - Vec<double, 3>(0.02, -0.01, 0.05)).norm() < 2e-3);
  }
}

TEST_CASE("alignment_window: when there is no more room every second pose goes, the newest stays") {
  using Window = AlignmentWindow<double>;
  const int count = Window::capacity + 6;
  const test::SimulatedAlignment<double> s(2, 1.5, {0.02, -0.01, 0.05}, {0.1, 0.2, -0.15}, count);
  Window window;
  int poses = 0;
  for (std::size_t k = 0; k < s.frames.size(); ++k)
    poses += window.add(TimeNs(k), s.frames[k].T_ref_cam, s.imu[k], 0.9 * step_s);
  REQUIRE(poses == Window::capacity + 3);  // from then on at twice the interval
  const auto found = window.align(s.T_body_cam, exact_poses<double>(), standard_gravity<double>);
  REQUIRE(found);
  REQUIRE(found.v_world_body.size() == std::size_t(Window::capacity) / 2 + 3);
  REQUIRE(found.scale == Approx(1.5).epsilon(1e-3));
  // The first of them is the second of all: the world of the alignment differs by a rotation about gravity.
  REQUIRE(found.v_world_body[0].norm() == Approx(s.truth[1].v_world_body.norm()).epsilon(1e-2));
}

TEST_CASE("alignment_window: beyond the longest interval the oldest pose goes") {
  using Window = AlignmentWindow<double>;
  const test::SimulatedAlignment<double> s(3, 1, {0, 0, 0}, {0, 0, 0});
  Window window;
  for (int k = 0; k < 8 * Window::capacity; ++k) window.add(TimeNs(k), s.frames[1].T_ref_cam, s.imu[1], 0.9 * step_s);
  const auto found = window.align(s.T_body_cam, exact_poses<double>(), standard_gravity<double>);
  REQUIRE(found.outcome != AlignmentOutcome::too_few_frames);
}

TEST_CASE("alignment_window: poses that were solved for again") {
  const test::SimulatedAlignment<double> s(1, 1.5, {0.02, -0.01, 0.05}, {0.1, 0.2, -0.15}, 17);
  AlignmentWindow<double> window;
  for (std::size_t k = 0; k < s.frames.size(); ++k) window.add(TimeNs(k), SE3<double>(), s.imu[k], 0.9 * step_s);
  REQUIRE(!window.align(s.T_body_cam, exact_poses<double>(), standard_gravity<double>));
  for (std::size_t k = 0; k < s.frames.size(); ++k) window.correct(TimeNs(k), s.frames[k].T_ref_cam);
  window.correct(99, SE3<double>());  // no pose of the window
  const auto found = window.align(s.T_body_cam, exact_poses<double>(), standard_gravity<double>);
  REQUIRE(found);
  REQUIRE(found.scale == Approx(1.5).epsilon(1e-3));
}

TEST_CASE("alignment_window: a new series clears the old one") {
  const test::SimulatedAlignment<double> s(3, 1, {0, 0, 0}, {0, 0, 0});
  AlignmentWindow<double> window;
  for (std::size_t k = 0; k < s.frames.size(); ++k)
    window.add(TimeNs(k), s.frames[k].T_ref_cam, s.imu[k], 0.9 * step_s);
  window.clear();
  REQUIRE(window.add(0, s.frames[0].T_ref_cam, s.imu[0],
                     0.9 * step_s));  // the first pose of a series, whatever its interval
  const auto found = window.align(s.T_body_cam, exact_poses<double>(), standard_gravity<double>);
  REQUIRE(found.outcome == AlignmentOutcome::too_few_frames);
}

TEST_CASE("alignment_window: poses of another scale are dropped, oldest first, until the others are consistent") {
  AlignmentWindow<double> window;
  test::SimulatedAlignment<double> s(3, 1.5, {0.02, -0.01, 0.05}, {0.1, 0.2, -0.15}, 17);
  for (std::size_t k = 0; k < 5; ++k) {
    const SE3<double>& T = s.frames[k].T_ref_cam;
    s.frames[k].T_ref_cam =
        SE3<double>(T.rotation(), s.frames[5].T_ref_cam.p() + 1.3 * (T.p() - s.frames[5].T_ref_cam.p()));
  }
  for (std::size_t k = 0; k < s.frames.size(); ++k)
    window.add(TimeNs(k), s.frames[k].T_ref_cam, s.imu[k], 0.9 * step_s);
  auto found = window.align(s.T_body_cam, {}, standard_gravity<double>);
  REQUIRE(found.outcome == AlignmentOutcome::positions_disagree);
  int forgotten = 0;
  for (; found.contradicts() && forgotten < 17; ++forgotten) {
    window.discard_oldest();
    found = window.align(s.T_body_cam, {}, standard_gravity<double>);
  }
  CAPTURE(name_of(found.outcome), forgotten);
  REQUIRE((found && forgotten >= 4 && forgotten <= 5));
  REQUIRE(found.scale == Approx(1.5).epsilon(0.02));
  for (int k = 0; k < 20; ++k) window.discard_oldest();
  REQUIRE(window.align(s.T_body_cam, {}, standard_gravity<double>).v_world_body.size() ==
          std::size_t(AlignmentWindow<double>::capacity / 2));
}

TEST_CASE("alignment_window: poses are corrected by a change of the time offset") {
  constexpr TimeNs step = 10'000'000;
  constexpr std::size_t late = 2, known = 70, count = 110;  // steps
  const test::SimulatedAlignment<double> s(1, 1.5, {0.02, -0.01, 0.05}, {0.1, 0.2, -0.15}, count, true, step);
  const double fine_s = double(step) * 1e-9, late_s = late * fine_s;
  AlignmentWindow<double> window;
  for (std::size_t k = 0; k + late < count; ++k) {  // each image shows where the camera is some steps later
    auto samples = s.imu[k < known ? k : k + late];
    if (k == known) {  // all that came since the frame before
      samples = s.imu[k];
      for (std::size_t j = k + 1; j <= k + late; ++j) {
        for (const ImuInterval<double>& d : s.imu[j].intervals()) samples.add(d);
      }
    }
    window.add(TimeNs(k) * step, s.frames[k + late].T_ref_cam, samples, 4.9 * fine_s, k < known ? 0 : late_s);
  }
  const auto thought = window.align(s.T_body_cam, {}, standard_gravity<double>, 0);
  const auto found = window.align(s.T_body_cam, {}, standard_gravity<double>, late_s);
  CAPTURE(name_of(thought.outcome), name_of(found.outcome), found.scale, found.gyro_residual, thought.gyro_residual);
  REQUIRE(found);
  REQUIRE(found.scale == Approx(1.5).epsilon(0.05));
  REQUIRE(thought.gyro_residual > 4 * found.gyro_residual);
}

TEST_CASE("alignment_window: poses of another time offset or readout time are outdated, and go first") {
  const std::size_t outdated = 8;
  const test::SimulatedAlignment<double> s(1, 1.5, {0.02, -0.01, 0.05}, {0.1, 0.2, -0.15}, 40);
  AlignmentWindow<double> window;
  const auto poses = [&](bool with_outdated) {
    return window.align(s.T_body_cam, {}, standard_gravity<double>, 0, with_outdated).v_world_body.size();
  };
  std::size_t k = 0;
  const auto add_until = [&](std::size_t end) {
    for (; k < end; ++k) window.add(TimeNs(k), s.frames[k].T_ref_cam, s.imu[k], 0.9 * step_s);
  };
  add_until(outdated);
  window.mark_outdated();
  REQUIRE((window.has_outdated() && poses(true) == outdated && poses(false) == 0));
  add_until(17);
  REQUIRE((poses(true) == 17 && poses(false) == 17 - outdated));
  add_until(AlignmentWindow<double>::capacity + 3);  // full: they make room
  REQUIRE((poses(true) == std::size_t(AlignmentWindow<double>::capacity) && poses(false) == 27 - outdated));
  window.discard_outdated();
  REQUIRE((!window.has_outdated() && poses(true) == 27 - outdated && poses(false) == 27 - outdated));
}
