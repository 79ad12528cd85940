// A single frame in a map: exact, consistent, and refused where one place does not tell it.
#include "plumbline/map/frame_localizer.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/core/square_root_information.hpp"
#include "plumbline/image/pyramid.hpp"
#include "plumbline/map/hamming_place_index.hpp"
#include "plumbline/map/place_graph.hpp"
#include "plumbline/residual/relative_pose.hpp"
#include "plumbline/residual/relative_sim3.hpp"
#include "simulated_places.hpp"

using namespace plumbline;
using test::looking_along;

namespace {

/// A room with a map of keyframes that look outward from its middle.
template <class Residual>
struct Room {
  using Places = PlaceGraph<Residual, 60, 200, 10>;
  using Localizer = FrameLocalizer<Places>;
  using S = typename Places::S;

  /// A frame whose image shows nothing: its features are told, no point is followed.
  struct View {
    TimeNs t_ns;
    S dt;
    const Pyramid<4, 160 * 128>&previous, &current;
    Pinhole<S> intrinsics;
    const Pinhole<S>& camera() const { return intrinsics; }
  };

  Pyramid<4, 160 * 128> image;
  test::SimulatedPlaces points;
  std::unique_ptr<Places> places = std::make_unique<Places>(PlaceGraphOptions{});
  std::unique_ptr<HammingPlaceIndex<60, 200>> index = std::make_unique<HammingPlaceIndex<60, 200>>();
  std::unique_ptr<Localizer> localizer = std::make_unique<Localizer>(FrameLocalizerOptions{});
  std::uint32_t id = 0;
  TimeNs t_ns = 0;
  bool is_ambiguous = false;

  explicit Room(std::uint64_t seed) : points(seed) {
    points.furnish(900, 4);
    const std::vector<std::uint8_t> gray(160 * 128, 100);
    REQUIRE(image.build(ImageView<const std::uint8_t>{gray.data(), 160, 128, 160}));
  }

  /// Keyframes all round at `p_world`, of a room that is as far away as `shift` from the first one.
  void map(const Vec<double, 3>& p_world, const Vec<double, 3>& shift = {0, 0, 0}, int count = 24) {
    for (int k = 0; k < count; ++k) {
      const SE3<double> T = looking_along(2 * 3.14159265358979 * k / count, p_world);
      Mat<S, 6, 6> covariance = zeros<S, 6, 6>();
      for (int i = 0; i < 6; ++i) covariance(i, i) = S(1e-6 * (1 + k));
      const SE3<double> shifted(T.rotation(), T.p() + shift);
      ++id;
      REQUIRE(places->add(id, TimeNs(id), shifted.template cast<S>(), SE3<S>(), covariance));
      auto& keyframe = places->keyframe(places->size() - 1);
      points.look(T, keyframe.features);
      places->retire(id, shifted.template cast<S>());
      FixedVector<BinaryDescriptor, 200> seen;
      for (const PlaceFeature& feature : keyframe.features) seen.push_back(feature.descriptor);
      index->add(std::uint32_t(places->slot(places->size() - 1)), {seen.data(), seen.size()});
    }
    places->update();
  }
  /// A frame after `dt_s`, from that true pose, without ranges.
  const typename Localizer::Pose* see(const SE3<double>& T, double dt_s = 0.03) {
    auto& frame = localizer->begin_frame();
    points.look(T, frame.features);
    for (PlaceFeature& feature : frame.features) feature.range = feature.sigma_range = 0;
    return find(dt_s);
  }
  const typename Localizer::Pose* find(double dt_s) {
    t_ns += TimeNs(1e9 * dt_s);
    const View view{t_ns, S(dt_s), image, image, {S(500), S(500), S(79.5), S(63.5), {}}};
    return localizer->find(
        view, SO3<S>(), *places, *index, PlacePoseOptions{}, 0.002, 0.1,
        [](const auto& keyframe) { return keyframe.is_retired; }, is_ambiguous);
  }
};

template <class S>
SE3<double> error_of(const SE3<double>& T, const SE3<S>& found) {
  return T.inverse() * found.template cast<double>();
}

}  // namespace

TEMPLATE_TEST_CASE("frame_localizer: a camera that turns through a mapped place", "", RelativePoseResidual<double>,
                   RelativePoseResidual<float>, RelativeSim3Residual<double>) {
  Room<TestType> room(2);
  room.map({0, 0, 0});
  int found = 0;
  for (int k = 0; k < 60; ++k) {
    const SE3<double> T = looking_along(0.1 + 0.1 * k, {0.2 * std::sin(0.1 * k), 0.1, 0.05});
    const auto* pose = room.see(T);
    if (!pose) continue;
    ++found;
    const SE3<double> error = error_of(T, pose->T_map_cam);
    CHECK(norm(error.p()) < 0.05);
    CHECK(norm(error.rotation().log()) < 0.01);
    CHECK(pose->inliers >= 20);
  }
  CHECK(found >= 57);  // the first one waits for the second
}

TEST_CASE("frame_localizer: its covariance is that of its errors") {
  double nees = 0;
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Room<RelativePoseResidual<double>> room(seed);
    room.map({0, 0, 0});
    const SE3<double> T = looking_along(0.4, {0.3, -0.2, 0.1});
    (void)room.see(T);
    const auto* pose = room.see(T);
    if (!pose) continue;
    ++found;
    const SE3<double> error = error_of(T, pose->T_map_cam);
    Vec<double, 6> e;
    set_segment(e, 0, error.rotation().log());
    set_segment(e, 3, error.p());
    const Result<Mat<double, 6, 6>> L = square_root_information(pose->covariance);
    REQUIRE(L);
    nees += squared_norm(Vec<double, 6>(times(*L, e)));
  }
  REQUIRE(found >= 38);
  CHECK(nees / found > 2);  // 6 expected
  CHECK(nees / found < 10);
}

TEST_CASE("frame_localizer: one frame alone, one after a gap and one from elsewhere do not count") {
  Room<RelativePoseResidual<double>> room(3);
  room.map({0, 0, 0});
  const SE3<double> here = looking_along(0, {0, 0, 0}), there = looking_along(2, {0, 0, 0});
  CHECK_FALSE(room.see(here));
  CHECK(room.see(here));
  CHECK_FALSE(room.see(here, 1.0));
  CHECK(room.see(here));
  CHECK_FALSE(room.see(there));
  CHECK(room.see(there));
}

TEST_CASE("frame_localizer: another place, no place and NaN give no pose") {
  Room<RelativePoseResidual<double>> room(4), other(104);
  room.map({0, 0, 0});
  for (int k = 0; k < 20; ++k) {
    auto& frame = room.localizer->begin_frame();
    other.points.look(looking_along(0.3 * k, {0, 0, 0}), frame.features);
    CHECK_FALSE(room.find(0.03));
  }
  const SE3<double> here = looking_along(0, {0, 0, 0});
  (void)room.see(here);
  REQUIRE(room.see(here));
  room.localizer->begin_frame();
  CHECK_FALSE(room.find(0.03));
  auto& frame = room.localizer->begin_frame();
  room.points.look(here, frame.features);
  for (PlaceFeature& feature : frame.features) feature.bearing.x() = std::numeric_limits<float>::quiet_NaN();
  CHECK_FALSE(room.find(0.03));
  room.localizer->forget();
  CHECK_FALSE(room.see(here));
  CHECK(room.see(here));
}

TEST_CASE("frame_localizer: of two rooms that look alike it tells neither") {
  Room<RelativePoseResidual<double>> room(5);
  room.map({0, 0, 0});
  room.map({0, 0, 0}, {30, 0, 0});
  int ambiguous = 0;
  for (int k = 0; k < 40; ++k) {
    CHECK_FALSE(room.see(looking_along(0.1 * k, {0, 0, 0})));
    ambiguous += room.is_ambiguous;
  }
  CHECK(ambiguous > 30);
}
