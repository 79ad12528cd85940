// Keyframes of a camera that passes the same wall twice: points of the first pass are found again in the second one.
#include "plumbline/map/local_adjustment.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/map/place_graph.hpp"
#include "plumbline/residual/relative_pose.hpp"
#include "plumbline/residual/relative_sim3.hpp"
#include "simulated_places.hpp"

using namespace plumbline;

namespace {

constexpr int pass = 7;
constexpr double sigma_rotation = 0.002, sigma_position = 0.006;  // of the odometry from keyframe to keyframe

template <class Residual>
struct Wall {
  using Places = PlaceGraph<Residual, 40, 120, 4>;
  using S = typename Places::S;
  std::unique_ptr<Places> places = std::make_unique<Places>(PlaceGraphOptions{});
  std::unique_ptr<LocalAdjustment<Places>> adjustment =
      std::make_unique<LocalAdjustment<Places>>(NeighborhoodOptions{});
  testing::Gaussian noise;
  std::vector<Vec<double, 3>> points;
  std::vector<SE3<double>> truth;
  SE3<double> T_world_body;

  explicit Wall(std::uint64_t seed, bool is_found_again = true) : noise(seed) {
    Random random(seed);
    for (int n = 0; n < 80; ++n)
      points.emplace_back(4 * random.uniform() - 2, 2 * random.uniform() - 1, 4 + random.uniform());
    for (int k = 0; k < 2 * pass; ++k) add(k < pass ? k : 2 * pass - 1 - k, k >= pass && is_found_again);
  }
  Vec<double, 3> random3(double sigma) { return sigma * Vec<double, 3>(noise(), noise(), noise()); }

  void add(int at, bool finds_again) {
    const SE3<double> T(SO3<double>::exp({0.02 * at, -0.03 * at, 0}), Vec<double, 3>(0.25 * at - 0.8, 0.02 * at, 0));
    Mat<double, 6, 6> Q = zeros<double, 6, 6>();
    for (int i = 0; i < 6; ++i) Q(i, i) = i < 3 ? sigma_rotation * sigma_rotation : sigma_position * sigma_position;
    if (truth.empty()) {
      T_world_body = T;
    } else {
      const SE3<double> error(SO3<double>::exp(random3(sigma_rotation)), random3(sigma_position));
      T_world_body = T_world_body * (truth.back().inverse() * T) * error;
    }
    truth.push_back(T);
    const auto id = std::uint32_t(truth.size());
    REQUIRE(places->add(id, TimeNs(id), T_world_body.template cast<S>(), {}, cast_to<S>(Q)));
    if (id > 1) places->set_covariance(id - 1, id, cast_to<S>(Q));
    auto& keyframe = places->keyframe(int(id) - 1);
    for (std::size_t n = 0; n < points.size(); ++n) {
      const Vec<double, 3> p = T.inverse() * points[n];
      PlaceFeature feature;
      feature.bearing = cast_to<float>(normalized(Vec<double, 3>(normalized(p) + random3(0.001))));
      feature.sigma_rad = 0.001f;
      feature.range = float(norm(p) * (1 + 0.005 * noise()));
      feature.sigma_range = (id == 1 ? 0.004f : 0.005f) * feature.range;  // the first one knows the points best
      feature.landmark = std::uint32_t(n + (finds_again ? 1000 : 0));
      feature.point = std::uint32_t(n);
      feature.is_recalled = finds_again;
      keyframe.features.push_back(feature);
    }
    places->retire(id, keyframe.T_world_body);
    places->update();
  }
  Vec<double, 3> position(int k) const {
    return Places::Poses::to_sim3(places->graph().pose(k)).template cast<double>().t();
  }
  /// Of the second pass.
  double error() const {
    double squares = 0;
    for (int k = pass; k < 2 * pass; ++k)
      squares += squared_norm(Vec<double, 3>(position(k) - truth[std::size_t(k)].p()));
    return std::sqrt(squares / pass);
  }
  bool adjust(int budget) {
    if (!adjustment->begin(*places, 2 * pass - 1)) return false;
    while (!adjustment->iterate(budget)) {
    }
    adjustment->apply(*places);
    return true;
  }
};

}  // namespace

TEMPLATE_TEST_CASE("local_adjustment: points found again undo the drift since they were seen", "",
                   RelativeSim3Residual<double>, RelativeSim3Residual<float>, RelativePoseResidual<double>) {
  double before = 0, after = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Wall<TestType> wall(seed);
    before += wall.error() / 10;
    REQUIRE(wall.adjust(1000));
    after += wall.error() / 10;
    // The present world moves with the newest keyframe.
    const auto S_map = wall.places->S_map_world();
    const auto newest = S_map * Sim3<typename Wall<TestType>::S>(wall.places->keyframe(2 * pass - 1).T_world_body);
    CHECK((newest.t().template cast<double>() - wall.position(2 * pass - 1)).norm() < 1e-5);
  }
  CHECK(before > 0.015);
  CHECK(after < 0.5 * before);
}

TEST_CASE("local_adjustment: without points that were found again there is nothing to do") {
  Wall<RelativeSim3Residual<double>> wall(3, false);
  CHECK_FALSE(wall.adjust(1000));
}

TEST_CASE("local_adjustment: the size of the slices changes nothing; keyframes that are gone are left out") {
  Wall<RelativeSim3Residual<double>> a(4), b(4), c(4);
  REQUIRE(a.adjust(100));
  REQUIRE(b.adjust(1 << 30));
  for (int k = 0; k < 2 * pass; ++k) CHECK(a.position(k) == b.position(k));
  REQUIRE(c.adjustment->begin(*c.places, 2 * pass - 1));
  REQUIRE(c.adjustment->iterate(1 << 30));
  REQUIRE(c.places->remove(pass));
  c.adjustment->apply(*c.places);
  CHECK((c.position(2 * pass - 2) - a.position(2 * pass - 1)).norm() < 1e-12);
}

TEST_CASE("local_adjustment: NaN in a feature does not enter") {
  Wall<RelativeSim3Residual<double>> wall(5);
  auto& features = wall.places->keyframe(pass + 1).features;
  for (std::size_t n = 0; n < 20; ++n) features[n].bearing[0] = std::numeric_limits<float>::quiet_NaN();
  const double before = wall.error();
  REQUIRE(wall.adjust(1000));
  CHECK(wall.error() < 0.5 * before);
}
