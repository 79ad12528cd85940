#include "plumbline/tracking/rotation_alignment.hpp"

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

TEST_CASE("rotation_alignment: finds a turn of forty pixels, and says how well it fits") {
  const Pinhole<double> camera{200, 200, 159.5, 119.5, {}};
  testing::Renderer renderer(*testing::make_scene("room"), camera, 320, 240);
  const auto trajectory = testing::Trajectory::for_scene("room");
  testing::Image<float> gray(320, 240), depth(320, 240);
  const SE3<double> T_world_body = trajectory->at(3).T_world_body;
  // Body x forward, z up; camera z forward.
  const SE3<double> T_body_cam(
      SO3<double>::from_matrix((Mat<double, 3, 3>() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished()),
      Vec<double, 3>::Zero());
  using Pyr = Pyramid<4, 320 * 240>;
  const auto pyramid_at = [&](const SE3<double>& T_world_cam) {
    renderer.render(T_world_cam, gray.view(), depth.view());
    testing::Image<std::uint8_t> bytes(320, 240);
    for (int y = 0; y < 240; ++y) {
      for (int x = 0; x < 320; ++x) bytes.view()(x, y) = std::uint8_t(std::clamp(gray.view()(x, y), 0.0f, 255.0f));
    }
    auto pyramid = std::make_unique<Pyr>();
    REQUIRE(pyramid->build(bytes.view()));
    return pyramid;
  };

  const SE3<double> T_prev = T_world_body * T_body_cam;
  const SO3<double> R_cur_prev = SO3<double>::exp({0.03, 0.2, -0.02});
  const SE3<double> T_cur(T_prev.rotation() * R_cur_prev.inverse(), T_prev.p());
  constexpr std::size_t pixels = (320 * 240) >> 8;
  auto thumbnail = std::make_unique<Thumbnail<pixels>>();
  auto aligner = std::make_unique<RotationAligner<Pinhole<double>, pixels>>();
  thumbnail->build(*pyramid_at(T_prev));
  aligner->set_previous(camera, *thumbnail);
  thumbnail->build(*pyramid_at(T_cur));
  const RotationAlignmentOptions options;
  const RotationAlignment<double> found = aligner->align(camera, *thumbnail, SO3<double>(), options);
  REQUIRE(found.valid);
  REQUIRE(minus(found.R_cur_prev, R_cur_prev).norm() < 0.02);  // 4 px of 40
  const RotationAlignment<double> from_truth = aligner->align(camera, *thumbnail, R_cur_prev, options);
  REQUIRE(from_truth.cost <= found.cost * 1.5f + 1);

  // Nothing in common: refused rather than invented.
  REQUIRE_FALSE(aligner->align(camera, *thumbnail, SO3<double>::exp({0, 2, 0}), options).valid);
}
