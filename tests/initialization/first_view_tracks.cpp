#include "plumbline/initialization/first_view_tracks.hpp"

#include <cmath>
#include <vector>

#include "catch.hpp"
#include "estimator/small_parts.hpp"

using namespace plumbline;
using test::SmallParts;

namespace {
struct Pairs {
  std::vector<Vec<double, 3>> first, now;
  void clear_pairs() { first.clear(), now.clear(); }
  void add_pair(const Vec<double, 3>& f1, const Vec<double, 3>& f2) { first.push_back(f1), now.push_back(f2); }
};
}  // namespace

TEST_CASE("first_view_tracks: corners are followed, from the place of the first view with the predicted rotation") {
  SmallParts parts;
  parts.draw(0);
  const SE3<double> T_world_first({}, {1, 2, 3});
  const auto first = parts.view(1);
  const int slot = parts.window->reset(first, {T_world_first}, *parts.tracker, parts.rig_state);
  parts.window->adopt_keyframe(first, slot, *parts.tracker, parts.propagation, parts.navigation);
  parts.window->begin_frame();
  parts.draw(2);
  const auto view = parts.view(2);
  const SE3<double> predicted(SO3<double>::exp({0, 0, 1e-3}), Vec<double, 3>(7, 7, 7));
  Pairs pairs;
  pairs.add_pair({}, {});
  const auto x = follow_first_view(view, SmallParts::Window::State{predicted}, pairs, parts.components());
  CHECK(x.T_world_body.p() == T_world_first.p());
  CHECK(minus(x.T_world_body.rotation(), predicted.rotation()).norm() == 0);
  CHECK(parts.window->frames().latest().T_world_body.p() == T_world_first.p());
  REQUIRE(pairs.first.size() > 10);
  int moved = 0;
  for (std::size_t k = 0; k < pairs.first.size(); ++k) {
    const Vec<double, 3>&a = pairs.first[k], &b = pairs.now[k];
    moved += std::abs(130 * (b.x() / b.z() - a.x() / a.z()) + 2) < 0.3;  // two pixels to the left
  }
  CHECK(moved > int(pairs.first.size()) * 3 / 4);
}

TEST_CASE("first_view_tracks: the rotation of the camera since the first view") {
  const SO3<double> R_body_cam = SO3<double>::exp({0.3, 0, 0}), turn = SO3<double>::exp({0, 0.2, 0.1});
  const SE3<double> T_body_cam(R_body_cam, Vec<double, 3>(1, 0, 0)), T_first(SO3<double>::exp({1, 2, 3}), {});
  const SE3<double> T_now(T_first.rotation() * R_body_cam * turn.inverse() * R_body_cam.inverse(),
                          Vec<double, 3>(0, 1, 0));
  CHECK(minus(rotation_since_first_view(T_first, T_now, T_body_cam), turn).norm() < 1e-12);
}
