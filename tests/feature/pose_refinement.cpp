// The pose of one frame from points and lines together.
#include "plumbline/feature/pose_refinement.hpp"

#include <limits>
#include <memory>
#include <type_traits>

#include "catch.hpp"
#include "feature/seen_lines.hpp"
#include "feature/seen_points.hpp"
#include "plumbline/sensor/mono.hpp"

using namespace plumbline;

namespace {

template <class S>
struct Scene {
  using Sensors = Rig<Rgbd<Pinhole<S>, 64 * 64>>;
  using Points = test::SeenPoints<S, Sensors>;
  using Lines = test::SeenLines<S, Sensors>;
  using Landmarks = LandmarkSet<typename Points::Store, typename Lines::Store>;
  using Estimate = PoseRefinement<Sensors, Landmarks>;
  static constexpr int latest = Points::used - 1;

  Points points;
  std::unique_ptr<Landmarks> landmarks = std::make_unique<Landmarks>(StoreOptions{}, StoreOptions{});
  std::unique_ptr<Estimate> estimate;
  SE3<S> T_true, T_body_cam, T;
  PosePrior<S> prior;
  typename Estimate::Covariance covariance;

  /// Seen from the last keyframe of both; the estimate begins off its pose.
  Scene(int point_count, int line_count, double noise_scale, const PoseRefinementOptions& options = {})
      : points(point_count, noise_scale), estimate(std::make_unique<Estimate>(options)) {
    const Lines lines(line_count, noise_scale);
    (*landmarks).template get<0>().landmarks() = points.store->landmarks();
    (*landmarks).template get<1>().landmarks() = lines.store->landmarks();
    T_true = points.window.T_world_body(latest);
    T_body_cam = points.T_body_cam.template cast<S>();
    T = off(1);
  }
  /// The true pose, so many times 5 mm and 0.2 degrees off on each axis.
  SE3<S> off(double scale) const {
    Vec<double, 6> d;
    d << 4e-3, -4e-3, 4e-3, 5e-3, -5e-3, 5e-3;
    return plus(T_true, Vec<S, 6>((scale * d).cast<S>()));
  }
  HealthReason refine() {
    return estimate->refine(points.rig, T_body_cam, *landmarks, points.window, off(1), prior, T, covariance);
  }
  double error() const { return double(minus(T, T_true).norm()); }
};

template <class S>
constexpr double tolerance = std::is_same_v<S, float> ? 3e-5 : 1e-6;  // the claimed sigmas weigh, the errors are none

}  // namespace

TEMPLATE_TEST_CASE("pose_refinement: exact points and lines, alone or together, give the exact pose", "", float,
                   double) {
  using S = TestType;
  const auto [point_count, line_count] = GENERATE(std::pair{30, 0}, std::pair{0, 12}, std::pair{30, 12});
  Scene<S> scene(point_count, line_count, 0);
  CAPTURE(point_count, line_count);
  REQUIRE(scene.error() > 5e-3);
  REQUIRE(scene.refine() == HealthReason::none);
  REQUIRE(scene.error() < tolerance<S>);
  REQUIRE(scene.covariance.diagonal().minCoeff() > 0);
  REQUIRE(scene.landmarks->seen_count() == point_count + line_count);
}

TEST_CASE("pose_refinement: more landmarks give a smaller covariance") {
  const auto trace = [](int points, int lines) {
    Scene<double> scene(points, lines, 0);
    REQUIRE(scene.refine() == HealthReason::none);
    return scene.covariance.trace();
  };
  const double few = trace(12, 0), more = trace(30, 0), all = trace(30, 12);
  REQUIRE(more < few);
  REQUIRE(all < more);
}

TEST_CASE("pose_refinement: smaller errors than stated are reported, larger ones inflate the covariance") {
  const auto scale2 = [](int points, int lines, double noise_scale) {
    Scene<double> scene(points, lines, noise_scale);
    REQUIRE(scene.refine() == HealthReason::none);
    return scene.estimate->noise_scale2();
  };
  const double as_claimed = scale2(200, 0, 1);  // below one: depth is claimed to err, too
  CHECK(as_claimed > 0.1);
  CHECK(as_claimed < 1);
  CHECK(scale2(200, 0, 0.5) == Approx(as_claimed / 4).epsilon(0.1));
  CHECK(scale2(200, 0, 0) < 1e-4);
  CHECK(scale2(0, 12, 0) < 1e-4);
  CHECK(scale2(200, 0, 4) == 1);
}

TEMPLATE_TEST_CASE("pose_refinement: outliers are removed from the frame, and the pose is right", "", float, double) {
  using S = TestType;
  Scene<S> scene(30, 12, 0);
  auto& points = (*scene.landmarks).template get<0>();
  for (std::size_t i = 0; i < 30; i += 6) points.landmarks()[i].current.uv += Vec<float, 2>(25, -15);
  REQUIRE(scene.refine() == HealthReason::none);
  REQUIRE(points.rejected().size() == 5);
  for (std::size_t i = 0; i < 30; i += 6) REQUIRE_FALSE(points.landmarks()[i].current.valid);
  REQUIRE(scene.refine() == HealthReason::none);
  REQUIRE(scene.error() < tolerance<S>);
}

TEST_CASE("pose_refinement: a prior holds where it is sure, and yields where it is not") {
  Scene<double> scene(30, 0, 0);
  scene.prior.valid = true;
  scene.prior.sigma.setConstant(1e-7);
  REQUIRE(scene.refine() == HealthReason::none);
  REQUIRE(minus(scene.T, scene.off(1)).norm() < 1e-4);
  scene.prior.sigma.setConstant(10);
  REQUIRE(scene.refine() == HealthReason::none);
  REQUIRE(scene.error() < 1e-5);

  Scene<double> unseen(0, 0, 0, PoseRefinementOptions{.min_inliers = 0});  // the prior alone
  unseen.prior.valid = true;
  unseen.prior.sigma << 0.1, 0.2, 0.3, 1, 2, 3;
  unseen.T = unseen.off(3);
  REQUIRE(unseen.refine() == HealthReason::none);
  REQUIRE(minus(unseen.T, unseen.off(1)).norm() < 1e-6);
  REQUIRE((unseen.covariance.diagonal().cwiseSqrt() - unseen.prior.sigma).norm() < 1e-3);
}

TEST_CASE("pose_refinement: reports the missing condition") {
  Scene<double> nothing(0, 0, 0);
  REQUIRE(nothing.refine() == HealthReason::unconstrained);
  Scene<double> few(6, 0, 0);
  REQUIRE(few.refine() == HealthReason::few_inliers);
  Scene<double> enough(6, 0, 0, PoseRefinementOptions{.min_inliers = 4});
  REQUIRE(enough.refine() == HealthReason::none);
  Scene<double> broken(30, 0, 0);
  broken.T = SE3<double>(SO3<double>(), Vec<double, 3>::Constant(std::numeric_limits<double>::quiet_NaN()));
  REQUIRE(broken.refine() != HealthReason::none);
}
