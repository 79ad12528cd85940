// Sparse image alignment on rendered frames of a room whose truth is exact.                    docs/math/direct.md
#include "plumbline/tracking/image_alignment.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/image/pyramid.hpp"
#include "plumbline/testing/renderer.hpp"
#include "plumbline/testing/rig.hpp"
#include "plumbline/testing/scenes.hpp"
#include "plumbline/testing/simulated_camera.hpp"
#include "plumbline/testing/trajectory.hpp"
#include "plumbline/tracking/corner_detector.hpp"

using namespace plumbline;

namespace {

constexpr int width = 320, height = 240;
using Pyr = Pyramid<4, width * height>;

struct Shot {
  SE3<double> T_world_body;
  testing::Image<float> gray{width, height}, depth{width, height};
  Pyr pyramid;
  std::array<ImageView<const std::uint8_t>, 4> levels;
};

struct Room {
  Pinhole<double> camera{200, 200, 159.5, 119.5, {}};
  SE3<double> T_body_cam = testing::simulated_T_body_camera();
  testing::Renderer renderer{*testing::make_scene("room"), camera, width, height};
  testing::Trajectory trajectory = *testing::Trajectory::for_scene("room");

  std::unique_ptr<Shot> shoot(const SE3<double>& T_world_body, float gain = 1, float bias = 0) {
    auto shot = std::make_unique<Shot>();
    shot->T_world_body = T_world_body;
    renderer.render(T_world_body * T_body_cam, shot->gray.view(), shot->depth.view());
    testing::Image<std::uint8_t> bytes(width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        bytes.view()(x, y) = std::uint8_t(std::clamp(gain * shot->gray.view()(x, y) + bias, 0.0f, 255.0f));
      }
    }
    REQUIRE(shot->pyramid.build(bytes.view()));
    for (int l = 0; l < 4; ++l) shot->levels[std::size_t(l)] = shot->pyramid.level(l);
    return shot;
  }
};

Room& room() {
  static Room made;
  return made;
}

template <class S>
struct Alignment {
  Pinhole<S> camera{200, 200, S(159.5), S(119.5), {}};
  SE3<S> T_body_cam = room().T_body_cam.cast<S>();
  std::vector<AlignmentSample<S>> samples;
  std::vector<AlignmentPatch> scratch;
  std::vector<float> errors;
  ImageAlignmentOptions options{.coarsest_level = 3};

  explicit Alignment(const Shot& previous) {
    FixedVector<Corner, 200> corners;
    detect_corners(previous.pyramid.level(0), static_cast<const Vec<float, 2>*>(nullptr), 0, CornerOptions{}, corners);
    for (const Corner& corner : corners) {
      const Vec<float, 2> uv(std::round(corner.uv.x()), std::round(corner.uv.y()));
      const float z = const_cast<Shot&>(previous).depth.view()(int(uv.x()), int(uv.y()));
      if (!(z > 0)) continue;
      const Vec<S, 3> b = camera.unproject(uv.template cast<S>()).bearing;
      samples.push_back({uv, Vec<float, 2>::Zero(), T_body_cam * Vec<S, 3>(b * (S(z) / b.z())), 1});
    }
    scratch.resize(samples.size());
    errors.resize(samples.size());
  }
  ImageAligner<Pinhole<S>> aligner() { return {camera, T_body_cam, samples, scratch, errors, options}; }
  ImageAlignment<S> align(const Shot& previous, const Shot& current, const IncrementPrior<S>& prior = {},
                          const SE3<S>& guess = {}) {
    return aligner().align(previous.levels, current.levels, prior, guess);
  }
};

template <class S>
Vec<S, 6> error_of(const SE3<S>& T_cur_prev, const Shot& previous, const Shot& current) {
  return minus(T_cur_prev, SE3<S>((current.T_world_body.inverse() * previous.T_world_body).cast<S>()));
}

}  // namespace

TEMPLATE_TEST_CASE("image_alignment: finds the motion of the body, coarse to fine, from no guess", "", float, double) {
  using S = TestType;
  const auto first = room().shoot(room().trajectory.at(3).T_world_body);
  for (const double dt : {0.05, 0.1}) {
    const auto second = room().shoot(room().trajectory.at(3 + dt).T_world_body);
    Alignment<S> alignment(*first);
    const double moved = double(error_of<S>({}, *first, *second).norm());
    const auto found = alignment.align(*first, *second);
    CAPTURE(dt, moved, alignment.samples.size(), found.patches, found.sigma_intensity);
    REQUIRE(found.valid);
    const Vec<S, 6> error = error_of(found.T_cur_prev, *first, *second);
    CHECK(error.template head<3>().norm() < S(3e-3));  // half a pixel of the finest level
    CHECK(error.template tail<3>().norm() < S(6e-3));
    CHECK(error.norm() < moved / 8);
    CHECK(std::abs(found.gain) < 0.05f);
  }
}

TEST_CASE("image_alignment: a frame that is brighter and has more contrast") {
  const auto first = room().shoot(room().trajectory.at(3).T_world_body);
  const auto second = room().shoot(room().trajectory.at(3.05).T_world_body, 1.3f, -20);
  Alignment<double> alignment(*first);
  const auto found = alignment.align(*first, *second);
  REQUIRE(found.valid);
  CHECK(error_of(found.T_cur_prev, *first, *second).norm() < 5e-3);
  CHECK(found.gain == Approx(0.3f).margin(0.06));
  CHECK(found.bias == Approx(-20).margin(6));
}

TEST_CASE("image_alignment: an eighth of the depths wrong") {
  const auto first = room().shoot(room().trajectory.at(3).T_world_body);
  const auto second = room().shoot(room().trajectory.at(3.1).T_world_body);
  Alignment<double> alignment(*first);
  for (std::size_t i = 0; i < alignment.samples.size(); i += 8) {
    auto& p = alignment.samples[i].p_body;
    p = alignment.T_body_cam * Vec<double, 3>(3 * (alignment.T_body_cam.inverse() * p));
  }
  const auto found = alignment.align(*first, *second);
  REQUIRE(found.valid);
  CHECK(error_of(found.T_cur_prev, *first, *second).norm() < 2e-2);
}

TEST_CASE("image_alignment: nothing in common, too few samples, numbers that are none") {
  const auto first = room().shoot(room().trajectory.at(3).T_world_body);
  const auto second = room().shoot(room().trajectory.at(3.05).T_world_body);
  Alignment<double> alignment(*first);
  const SE3<double> away(SO3<double>::exp({0, 0, 2.5}), Vec<double, 3>::Zero());
  CHECK_FALSE(alignment.align(*first, *second, {}, away).valid);
  const SE3<double> nowhere(SO3<double>(), Vec<double, 3>::Constant(std::nan("")));
  CHECK_FALSE(alignment.align(*first, *second, {}, nowhere).valid);
  alignment.samples.resize(4);
  CHECK_FALSE(alignment.align(*first, *second).valid);
  alignment.samples.clear();
  CHECK_FALSE(alignment.align(*first, *second).valid);
}

TEMPLATE_TEST_CASE("image_alignment: the prior determines what the images do not", "", float, double) {
  using S = TestType;
  const auto first = room().shoot(room().trajectory.at(3).T_world_body);
  const auto second = room().shoot(room().trajectory.at(3.05).T_world_body);
  const SE3<S> truth = (second->T_world_body.inverse() * first->T_world_body).cast<S>();
  Vec<S, 6> sigma;
  sigma << Vec<S, 3>::Constant(S(1e-6)), Vec<S, 3>::Constant(S(1e-6));
  const auto prior = IncrementPrior<S>::of(truth, sigma);
  Alignment<S> alignment(*first);
  const auto found = alignment.align(*first, *second, prior, {});
  REQUIRE(found.valid);
  CHECK(error_of(found.T_cur_prev, *first, *second).norm() < S(1e-4));
}
