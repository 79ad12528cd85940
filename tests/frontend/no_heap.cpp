// Whole frames of points and lines, from the image to the window's equations, allocate nothing.
#include "allocation_counter.hpp"

#include <array>
#include <memory>
#include <type_traits>
#include <utility>

#include "catch.hpp"
#include "estimator/simulation.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/feature/pose_refinement.hpp"
#include "plumbline/feature/row_motion.hpp"
#include "plumbline/feature/row_ranges.hpp"
#include "plumbline/feature/window_terms.hpp"
#include "plumbline/frontend/flow.hpp"
#include "plumbline/frontend/front_ends.hpp"
#include "plumbline/frontend/image_pair.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/solver/normal_equations.hpp"
#include "plumbline/state/frame_window.hpp"

using namespace plumbline;
using test::SimulatedRgbd;

namespace {

constexpr int slots = 3;
using Sensors = Rig<Rgbd<Pinhole<float>, SimulatedRgbd::width * SimulatedRgbd::height>>;
using Set = Features<Points<120>, Lines<40>>;
using Ends = FrontEnds<Flow, Sensors, slots, Set>;
using Landmarks = Ends::Landmarks;
using Window = FrameWindow<float, VisualLayout, slots>;
using PointTerms = WindowTerms<std::remove_cvref_t<decltype(std::declval<Landmarks&>().get<0>())>>;
using LineTerms = WindowTerms<std::remove_cvref_t<decltype(std::declval<Landmarks&>().get<1>())>>;

}  // namespace

TEST_CASE("no heap: detect, track, RANSAC, estimate, refine, locate, record, linearize, eliminate, drop") {
  const SimulatedRgbd room(6);
  Sensors rig{};
  rig.vision.camera = {268, 268, 159.5f, 119.5f, {}};
  rig.vision.width = SimulatedRgbd::width;
  rig.vision.height = SimulatedRgbd::height;
  const auto images = std::make_unique<ImagePair<Sensors>>(RotationAlignmentOptions{});
  const auto front_ends = std::make_unique<Ends>(Ends::Options{});
  const std::unique_ptr<Landmarks> landmarks{new Landmarks(Ends::make_landmarks(Ends::Options{}))};
  const auto pose = std::make_unique<PoseRefinement<Sensors, Landmarks>>(PoseRefinementOptions{});
  const auto points = std::make_unique<PointTerms>();
  const auto lines = std::make_unique<LineTerms>();
  const auto window = std::make_unique<Window>();
  const auto views = std::make_unique<WindowViews<float, slots>>();
  const auto pairs = std::make_unique<PointTerms::Pairs>();
  const auto equations = std::make_unique<NormalEquations<double, state::Pose::dim, slots>>();
  const auto step = std::make_unique<NormalEquations<double, state::Pose::dim, slots>::Vector>();

  int estimated = 0, tracked = 0;
  bool eliminated = true;
  ReadoutBorder border;
  double cost = 0;
  const long allocations = test::allocations_of([&] {
    for (int i = 0; i < 6; ++i) {
      const SE3<float> T_true = room.T_world_cam[std::size_t(i)].cast<float>();
      const Sensors::Frame frame{room.t_ns[std::size_t(i)], room.frames[std::size_t(i)].gray.view(),
                                 room.frames[std::size_t(i)].depth.view()};
      if (!images->take_in(frame)) return;
      View<Sensors> view = images->view(rig, frame, SE3<float>(), {0.01f, 0.0f}, 0.05f);
      view.shutter.set_motion(Vec<float, 3>(0.1f, 0.2f, -0.1f), Vec<float, 3>(0.3f, 0.0f, 0.1f), 0.5f);
      SE3<float> T = T_true;
      if (i > 0) {
        images->align_motion(view, SE3<float>(), 2.0f, /*after_gap=*/true);
        front_ends->follow(view, *window, *landmarks, T);
        front_ends->find_consensus(view, *window, *landmarks, {}, T);
        Mat<float, 6, 6> covariance;
        estimated += pose->refine(rig, SE3<float>(), *landmarks, *window, T, {}, T, covariance) == HealthReason::none;
        front_ends->refine(view, *window, *landmarks, T);
        front_ends->locate(view, *window, *landmarks, T);
      }
      if (window->full()) {
        const int oldest = window->oldest();
        points->for_each_leaving(oldest, rig, landmarks->get<0>(), *window, *views, [](const auto&, const auto&) {});
        lines->for_each_leaving(oldest, rig, landmarks->get<1>(), *window, *views, [](const auto&, const auto&) {});
        landmarks->for_each([&](auto& store) { store.remove_frame(oldest); });
        window->remove(oldest);
      }
      front_ends->detect(view, *window, *landmarks, window->insert(frame.t_ns, {T}));
      images->keep(view, T);
      if (window->size() < 2) continue;
      views->update(*window, SE3<float>());
      views->set_transports(*window, *pairs);
      pairs->reset();
      cost = points->linearize(rig, landmarks->get<0>(), *window, *views, *pairs);
      cost += lines->linearize(rig, landmarks->get<1>(), *window, *views, *pairs);
      equations->reset(slots);
      for (int k = 0; k < slots; ++k) equations->add_block(k, k, Mat<double, 6, 6>::Identity());
      pairs->add_to(*equations);
      eliminated = eliminated && points->eliminate(landmarks->get<0>(), 1e-3f, *pairs, *equations) &&
                   lines->eliminate(landmarks->get<1>(), 1e-3f, *pairs, *equations) && equations->solve(1e-3, *step);
      points->solve(landmarks->get<0>(), *pairs, *step, state::Pose::dim);
      lines->solve(landmarks->get<1>(), *pairs, *step, state::Pose::dim);
      points->step(landmarks->get<0>());
      lines->step(landmarks->get<1>());
      points->finish(rig, landmarks->get<0>(), *window, *views, *pairs);
      lines->finish(rig, landmarks->get<1>(), *window, *views, *pairs);
      pairs->reset();
      points->exchange_residuals(rig, landmarks->get<0>(), *window, *views, *pairs, border);
      lines->exchange_residuals(rig, landmarks->get<1>(), *window, *views, *pairs, border);
      points->subtract_eliminated(landmarks->get<0>(), border);
      set_motion(*landmarks, window->newest(), view, 0.01f);
      landmarks->for_each([&](auto& store) {
        store.change_readout(1e-4f);
        set_ranges(store, *window, T, SE3<float>(), 0.01f, /*all=*/true);
      });
    }
    tracked = front_ends->lasting_count(*landmarks);
  });
  REQUIRE(allocations == 0);
  REQUIRE(estimated == 5);
  REQUIRE(tracked > 50);
  REQUIRE(eliminated);
  REQUIRE(border.information > 0);
  REQUIRE(cost > 0);
}
