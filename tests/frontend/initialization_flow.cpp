// Points that end with the start, on a rendered frame.
#include "plumbline/frontend/initialization_flow.hpp"

#include <memory>

#include "catch.hpp"
#include "estimator/simulation.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/feature/landmark_store.hpp"
#include "plumbline/feature/point_kind.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/state/frame_window.hpp"

using namespace plumbline;
using test::SimulatedRgbd;

TEMPLATE_TEST_CASE("initialization_flow: points are detected until initialization ends, and again after a reset", "",
                   float, double) {
  using S = TestType;
  using Sensors = Rig<Mono<Pinhole<S>, SimulatedRgbd::width * SimulatedRgbd::height>>;
  using Store = LandmarkStore<PointKind<Sensors>, 100, 3>;

  const SimulatedRgbd room(1);
  Sensors rig{};
  rig.vision.camera = {S(room.camera.fx), S(room.camera.fy), S(room.camera.cx), S(room.camera.cy), {}};
  rig.vision.width = SimulatedRgbd::width;
  rig.vision.height = SimulatedRgbd::height;
  const auto pyramid = std::make_unique<RigPyramid<Sensors>>();
  REQUIRE(pyramid->build(room.frames[0].gray.view()));
  const View<Sensors> view{
      0, S(0), rig, *pyramid, *pyramid, {}, SE3<S>(), SE3<S>(), {rig.vision.camera, rig.vision.height, S(0)}};
  FrameWindow<S, VisualLayout, 3> window;
  const int slot = window.insert(0, {});
  const auto store = std::make_unique<Store>(StoreOptions{});
  const auto flow = std::make_unique<InitializationFlow<Store>>(PointFlowOptions{});

  flow->detect(view, window, *store, slot);
  CHECK(store->landmarks().size() > 50);
  flow->follow(view, window, *store, SE3<S>());  // as PointFlow does
  flow->refine(view, window, *store, SE3<S>());
  flow->locate(view, window, *store, SE3<S>());
  CHECK(store->seen_count() > 50);
  int pairs = 0;
  flow->for_each_pair(view, *store, slot, [&](const auto&, const auto&) { ++pairs; });
  CHECK(pairs == store->seen_count());

  flow->end_initialization(*store);
  CHECK(store->landmarks().empty());
  flow->detect(view, window, *store, slot);
  CHECK(store->landmarks().empty());
  flow->begin_initialization();
  flow->detect(view, window, *store, slot);
  CHECK(store->landmarks().size() > 50);
}
