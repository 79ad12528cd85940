// Corners of a rendered room, whose ranges are exact, searched for in a second image of a camera with distortion.
#include "plumbline/tracking/epipolar_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include "catch.hpp"
#include "plumbline/camera/equidistant.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/camera/radtan.hpp"
#include "plumbline/testing/rig.hpp"
#include "plumbline/testing/scenes.hpp"
#include "plumbline/testing/simulated_camera.hpp"
#include "plumbline/testing/trajectory.hpp"
#include "plumbline/tracking/corner_detector.hpp"

using namespace plumbline;

namespace {

constexpr int width = 320, height = 240;
using Pyr = Pyramid<4, width * height>;
constexpr auto as_it_is = [](const auto& uv, auto) { return uv; };

/// Two images 0.4 s apart, 0.1 m, and the corners of the first with what is true of them.
template <class Camera>
struct Room {
  using S = typename Camera::Scalar;
  struct Seen {
    ReferencePatch patch;
    Vec<S, 3> bearing;
    S inverse_range;
    Vec<float, 2> truth;  ///< in the second image [px]
    S px_per_lambda;      ///< |du/dlambda| there
  };

  Camera camera;
  std::unique_ptr<Pyr> current = std::make_unique<Pyr>();
  SE3<S> T_cur_ref;
  std::vector<Seen> corners;

  Room(const Camera& camera_, const auto& exact) : camera(camera_) {
    const auto trajectory = *testing::Trajectory::for_scene("room");
    const SE3<double> T_body_cam = testing::simulated_T_body_camera();
    const testing::Scene scene = *testing::make_scene("room");
    testing::SimulatedCamera simulated(testing::Renderer(scene, exact, width, height, 2), T_body_cam, {}, 1);
    const auto pose = [&](double t) { return trajectory.at(t).T_world_body * T_body_cam; };
    const SE3<double> T_world_ref = pose(2.0), T_cur_world = pose(2.4).inverse();
    T_cur_ref = (T_cur_world * T_world_ref).template cast<S>();
    const auto first = simulated.frame(trajectory, 2.0, 1), second = simulated.frame(trajectory, 2.4, 2);
    const auto reference = std::make_unique<Pyr>();
    REQUIRE(reference->build(first.gray.view()));
    REQUIRE(current->build(second.gray.view()));
    FixedVector<Corner, 300> found;
    CornerOptions dense;
    dense.cell_px = 16;
    detect_corners(reference->level(0), nullptr, 0, dense, found);
    for (const Corner& corner : found) {
      Seen seen;
      const auto ray = exact.unproject(corner.uv.template cast<double>());
      if (!ray.valid || !seen.patch.capture(*reference, corner.uv)) continue;
      const double range = scene.intersect(T_world_ref.p(), T_world_ref.rotation() * ray.bearing);
      if (!(range > 0.3 && range < 20)) continue;
      const Vec<double, 3> p = T_cur_world * (T_world_ref * Vec<double, 3>(range * ray.bearing));
      const auto at = exact.project(p);
      if (!at.valid || !current->level(0).contains(float(at.uv.x()), float(at.uv.y()), 12.0f)) continue;
      const Vec<double, 3> t = T_cur_ref.p().template cast<double>();
      seen.bearing = ray.bearing.template cast<S>();
      seen.inverse_range = S(1 / range);
      seen.truth = at.uv.template cast<float>();
      seen.px_per_lambda = S((at.J_uv_p * t).norm() * range);
      corners.push_back(seen);
    }
    REQUIRE(corners.size() > 60);
  }

  EpipolarMatch<S> search(const Seen& corner, const InverseRangeInterval<S>& lambda, const auto& seen) const {
    return search_epipolar_curve(camera, corner.patch, corner.bearing, lambda, T_cur_ref, *current, seen,
                                 EpipolarSearchOptions{}, AlignmentOptions{});
  }
  EpipolarMatch<S> search(const Seen& corner, const InverseRangeInterval<S>& lambda) const {
    return search(corner, lambda, as_it_is);
  }
};

/// The expected inverse range is wrong by a half to one side or the other.
template <class S>
InverseRangeInterval<S> wide(S truth, std::size_t i) {
  const S expected = truth * (i % 2 ? S(1.5) : S(0.6));
  return {expected, S(0.02), 2 * expected};
}

struct Score {
  int found = 0, wrong = 0;
  std::vector<float> error_px, error_inverse_range;
};
template <class Camera>
Score search_all(const Room<Camera>& room) {
  using S = typename Camera::Scalar;
  Score score;
  for (std::size_t i = 0; i < room.corners.size(); ++i) {
    const auto& corner = room.corners[i];
    const EpipolarMatch<S> match = room.search(corner, wide(corner.inverse_range, i));
    if (!match.aligned.valid) continue;
    const float error = (match.aligned.uv - corner.truth).norm();
    score.error_px.push_back(error);
    score.error_inverse_range.push_back(
        float(std::abs(match.inverse_range - corner.inverse_range) * corner.px_per_lambda));
    ++score.found;
    score.wrong += error > 2;
  }
  std::sort(score.error_px.begin(), score.error_px.end());
  std::sort(score.error_inverse_range.begin(), score.error_inverse_range.end());
  return score;
}

template <class Camera>
void finds_them(const Camera& camera, const auto& exact) {
  const Room<Camera> room(camera, exact);
  const Score score = search_all(room);
  CAPTURE(room.corners.size(), score.found, score.wrong);
  REQUIRE(score.found > int(room.corners.size()) * 6 / 10);
  CHECK(score.wrong * 20 <= score.found);
  CHECK(score.error_px[score.error_px.size() / 2] < 0.2f);
  CHECK(score.error_inverse_range[score.error_inverse_range.size() / 2] < 1.0f);  // steps of 0.8 px
}

}  // namespace

TEMPLATE_TEST_CASE("epipolar search: finds corners whose range is wrong by a half, with any camera", "", float,
                   double) {
  using S = TestType;
  finds_them(Pinhole<S, RadTan>{S(230), S(230), S(159.5), S(119.5), {S(-0.28), S(0.07), S(2e-4), S(1e-4)}},
             Pinhole<double, RadTan>{230, 230, 159.5, 119.5, {-0.28, 0.07, 2e-4, 1e-4}});
  finds_them(Equidistant<S>(S(120), S(120), S(159.5), S(119.5), S(-0.01), S(0.02), S(-0.01), S(0.002)),
             Equidistant<double>(120, 120, 159.5, 119.5, -0.01, 0.02, -0.01, 0.002));
}

TEST_CASE("epipolar search: where the image shows it elsewhere than the middle of the frame") {
  const Pinhole<double> camera{230, 230, 159.5, 119.5};
  const Room<Pinhole<double>> room(camera, camera);
  // The patch is shifted, and the shift is given: the same as no shift.
  int both = 0;
  for (std::size_t i = 0; i < room.corners.size(); ++i) {
    auto corner = room.corners[i];
    const InverseRangeInterval<double> lambda = wide(corner.inverse_range, i);
    const auto match = room.search(corner, lambda);
    const auto told =
        room.search(corner, lambda, [](const auto& uv, double) { return Vec<double, 2>(uv.x() + 0.0, uv.y()); });
    CHECK(match.aligned.valid == told.aligned.valid);
    const auto off =
        room.search(corner, lambda, [](const auto& uv, double) { return Vec<double, 2>(uv.x(), uv.y() + 40); });
    both += match.aligned.valid && off.aligned.valid && (match.aligned.uv - off.aligned.uv).norm() < 1;
  }
  CHECK(both < int(room.corners.size()) / 10);
}

TEST_CASE("epipolar search: refuses what is not there, what is there twice and what has no texture") {
  const Pinhole<double> camera{230, 230, 159.5, 119.5};
  const Room<Pinhole<double>> room(camera, camera);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  int elsewhere = 0, stripes_found = 0, tried = 0, one_found = 0;
  const auto stripes = std::make_unique<Pyr>();
  std::vector<std::uint8_t> pixels(width * height);
  for (int k = 0; k < width * height; ++k) {
    const int x = k % width, y = k / width;
    pixels[std::size_t(k)] = std::uint8_t(128 + 60 * std::sin(0.5 * x) * std::sin(0.5 * y));  // again and again
  }
  REQUIRE(stripes->build({pixels.data(), width, height, width}));
  for (const auto& corner : room.corners) {
    // An interval that does not hold it.
    const double far = corner.inverse_range + 25 / corner.px_per_lambda;
    const auto match = room.search(corner, {far, far - 10 / corner.px_per_lambda, far + 10 / corner.px_per_lambda});
    elsewhere += match.aligned.valid;
  }
  // A camera that moves aside sees all of them on a row of its pattern; +-30 px hold three or more alike.
  const SE3<double> aside(SO3<double>(), Vec<double, 3>(0.2, 0, 0));
  for (const auto& corner : room.corners) {
    ReferencePatch patch;
    const Vec<float, 2> uv = camera.project(corner.bearing).uv.cast<float>();
    if (!patch.capture(*stripes, uv)) continue;
    const double px = 0.2 * camera.fx / corner.bearing.z(), lambda = 40 / px;
    const auto look = [&](double reach_px) {
      return search_epipolar_curve(camera, patch, corner.bearing,
                                   {lambda, lambda - reach_px / px, lambda + reach_px / px}, aside, *stripes, as_it_is,
                                   EpipolarSearchOptions{}, AlignmentOptions{})
          .aligned;
    };
    stripes_found += look(30).valid;
    ++tried;
    // Within half a period there is one alone.
    if (const Alignment one = look(5); one.valid) ++one_found;
  }
  CAPTURE(room.corners.size());
  CHECK(elsewhere < int(room.corners.size()) / 10);
  CAPTURE(tried, one_found);
  CHECK(stripes_found == 0);
  CHECK(one_found > tried / 2);

  const auto& corner = room.corners.front();
  const double lambda = corner.inverse_range;
  std::fill(pixels.begin(), pixels.end(), std::uint8_t(90));
  REQUIRE(stripes->build({pixels.data(), width, height, width}));
  ReferencePatch plain;
  REQUIRE(plain.capture(*stripes, corner.truth));
  const auto refused = [&](const ReferencePatch& patch, const Vec<double, 3>& bearing,
                           const InverseRangeInterval<double>& interval, const SE3<double>& T) {
    return !search_epipolar_curve(camera, patch, bearing, interval, T, *stripes, as_it_is, EpipolarSearchOptions{},
                                  AlignmentOptions{})
                .aligned.valid;
  };
  const InverseRangeInterval<double> good{lambda, lambda / 2, lambda * 2};
  CHECK(refused(plain, corner.bearing, good, room.T_cur_ref));
  CHECK(refused(corner.patch, corner.bearing, good, room.T_cur_ref));
  CHECK(refused(ReferencePatch{}, corner.bearing, good, room.T_cur_ref));
  for (const double bad : {nan, 0.0, -1.0, std::numeric_limits<double>::infinity()}) {
    CHECK(refused(corner.patch, corner.bearing, {bad, lambda / 2, lambda * 2}, room.T_cur_ref));
    CHECK_FALSE(room.search(corner, {bad, lambda / 2, lambda * 2}).aligned.valid);
  }
  CHECK(refused(corner.patch, Vec<double, 3>(nan, 0, 1), good, room.T_cur_ref));
  CHECK(refused(corner.patch, corner.bearing, good, SE3<double>(SO3<double>(), Vec<double, 3>(nan, 0, 0))));
  CHECK(refused(corner.patch, corner.bearing, good,
                SE3<double>(SO3<double>::exp({0, 3.1, 0}), Vec<double, 3>::Zero())));  // behind
  // The ends are no numbers: nothing but the middle is looked at, and the loops end.
  CHECK(refused(corner.patch, corner.bearing, {lambda, nan, nan}, room.T_cur_ref));
}

TEST_CASE("epipolar search: no baseline leaves one place, that of the turned camera") {
  const Pinhole<double> camera{230, 230, 159.5, 119.5};
  Room<Pinhole<double>> room(camera, camera);
  room.T_cur_ref = SE3<double>(room.T_cur_ref.rotation(), Vec<double, 3>::Zero());
  for (const auto& corner : room.corners) {
    const auto match = room.search(corner, {corner.inverse_range, 0.01, 5.0});
    if (match.aligned.valid) CHECK(match.inverse_range == corner.inverse_range);
  }
}
