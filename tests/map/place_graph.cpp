#include "plumbline/map/place_graph.hpp"

#include <memory>

#include "catch.hpp"
#include "plumbline/residual/relative_sim3.hpp"

using namespace plumbline;

TEST_CASE("place_graph: a keyframe from before the camera had ranges is as certain as those after it") {
  using Places = PlaceGraph<RelativeSim3Residual<double>, 10, 8, 4>;
  const auto places = std::make_unique<Places>(PlaceGraphOptions{});
  const auto covariance = [](double sigma) {
    Mat<double, 6, 6> P = zeros<double, 6, 6>();
    for (int a = 0; a < 6; ++a) P(a, a) = a < 3 ? 1e-6 : sigma * sigma;
    return P;
  };
  const double sigmas[] = {1e-3, 500, 0.01, 0.012, 0.013};
  for (std::uint32_t id = 1; id <= 5; ++id)
    REQUIRE(places->add(id, TimeNs(id), SE3<double>(SO3<double>(), Vec<double, 3>(0.2 * id, 0, 0)), {},
                        covariance(sigmas[id - 1])));
  for (std::uint32_t id = 1; id <= 3; ++id) places->retire(id, places->keyframe(int(id) - 1).T_world_body);
  places->update();
  for (int k = 1; k <= 3; ++k) {
    const auto P = places->graph().odometry(k).covariance();
    for (int a = 3; a < 6; ++a) CHECK(std::sqrt(P(a, a)) < 0.02);
  }
  CHECK(std::sqrt(places->graph().odometry(1).covariance()(3, 3)) > 0.005);  // what the third one says of the second
}

TEST_CASE("place_graph: without keyframes there is nothing to bring up to date") {
  using Places = PlaceGraph<RelativeSim3Residual<double>, 10, 8, 4>;
  const auto places = std::make_unique<Places>(PlaceGraphOptions{});
  places->update();  // a map is asked for frames before it has keyframes
  CHECK(places->size() == 0);
  CHECK(places->graph().nodes() == 0);
}
