#include "plumbline/tracking/rotation_alignment.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/image/pyramid.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/testing/renderer.hpp"
#include "plumbline/testing/scenes.hpp"
#include "plumbline/testing/simulated_camera.hpp"
#include "plumbline/testing/trajectory.hpp"

using namespace plumbline;

namespace {

constexpr std::size_t pixels = (320 * 240) >> 8;
const Pinhole<double> camera{200, 200, 159.5, 119.5, {}};
using Pyr = Pyramid<4, 320 * 240>;

/// What cameras see of a room, and how it compares.
struct Views {
  testing::Renderer renderer{*testing::make_scene("room"), camera, 320, 240};
  // Body x forward, z up; camera z forward.
  SE3<double> T_prev =
      testing::Trajectory::for_scene("room")->at(3).T_world_body *
      SE3<double>(SO3<double>::from_matrix((Mat<double, 3, 3>() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished()),
                  Vec<double, 3>::Zero());
  double range = 0;  ///< harmonic mean in the previous image
  std::unique_ptr<Thumbnail<pixels>> thumbnail = std::make_unique<Thumbnail<pixels>>();
  std::unique_ptr<RotationAligner<Pinhole<double>, pixels>> aligner =
      std::make_unique<RotationAligner<Pinhole<double>, pixels>>();

  explicit Views(const SE3<double>& T_cur_prev) {
    see(T_prev);
    aligner->set_previous(camera, *thumbnail);
    see(T_prev * T_cur_prev.inverse());
  }
  RotationAlignment<double> align(const SO3<double>& guess, const Vec<double, 3>& parallax) const {
    return aligner->align(camera, *thumbnail, guess, parallax, {});
  }

 private:
  void see(const SE3<double>& T_world_cam) {
    testing::Image<float> gray(320, 240), depth(320, 240);
    renderer.render(T_world_cam, gray.view(), depth.view());
    testing::Image<std::uint8_t> bytes(320, 240);
    double inverse_sum = 0;
    for (int y = 0; y < 240; ++y) {
      for (int x = 0; x < 320; ++x) {
        bytes.view()(x, y) = std::uint8_t(std::clamp(gray.view()(x, y), 0.0f, 255.0f));
        inverse_sum += 1 / (double(depth.view()(x, y)) * std::hypot(1, (x - 159.5) / 200, (y - 119.5) / 200));
      }
    }
    if (!(range > 0)) range = 320 * 240 / inverse_sum;
    auto pyramid = std::make_unique<Pyr>();
    REQUIRE(pyramid->build(bytes.view()));
    thumbnail->build(*pyramid);
  }
};

}  // namespace

TEST_CASE("rotation_alignment: finds a rotation of forty pixels, and reports its residual") {
  const SO3<double> R_cur_prev = SO3<double>::exp({0.03, 0.2, -0.02});
  const Vec<double, 3> still = Vec<double, 3>::Zero();
  const Views views(SE3<double>(R_cur_prev, still));
  const RotationAlignment<double> found = views.align(SO3<double>(), still);
  REQUIRE(found.valid);
  REQUIRE(minus(found.R_cur_prev, R_cur_prev).norm() < 0.02);  // 4 px of 40
  const RotationAlignment<double> from_truth = views.align(R_cur_prev, still);
  REQUIRE(from_truth.cost <= found.cost * 1.5f + 1);

  // Nothing in common: refused rather than invented.
  REQUIRE_FALSE(views.align(SO3<double>::exp({0, 2, 0}), still).valid);
}

TEST_CASE("rotation_alignment: what a translation moves in the image is no rotation") {
  const SE3<double> T_cur_prev(SO3<double>::exp({0, 0.02, 0}), {0.15, 0, 0});
  const Views views(T_cur_prev);
  const RotationAlignment<double> told = views.align(SO3<double>(), T_cur_prev.p() / views.range);
  const RotationAlignment<double> not_told = views.align(SO3<double>(), Vec<double, 3>::Zero());
  REQUIRE((told.valid && not_told.valid));
  REQUIRE(minus(told.R_cur_prev, T_cur_prev.rotation()).norm() < 0.006);
  REQUIRE(minus(not_told.R_cur_prev, T_cur_prev.rotation()).norm() > 0.02);
}
