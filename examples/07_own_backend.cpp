// A backend of one's own: what estimates the keyframes and the landmarks that they see. This one leaves every keyframe
// where its frame was found and improves the landmarks alone, of all kinds: less work than a window whose poses move.
// It is given in place of SlidingWindow.
#include <cmath>
#include <cstdio>
#include <memory>

#include "plumbline/backend/backend.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/feature/window_terms.hpp"
#include "plumbline/feature/window_views.hpp"
#include "plumbline/frontend/flow.hpp"
#include "plumbline/map/retired.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/solver/normal_equations.hpp"
#include "plumbline/state/frame_window.hpp"
#include "plumbline/testing/room_run.hpp"

namespace pl = plumbline;

template <pl::Propagation PropagationT, class LandmarksT, int K>
class StructureBackend {
  static_assert(!PropagationT::has_imu_factors, "this backend holds all frames fixed: it cannot use IMU factors");

 public:
  using Sensors = typename PropagationT::Sensors;
  using S = typename PropagationT::S;
  using Layout = typename PropagationT::Layout;
  using State = typename PropagationT::State;
  using Factor = typename PropagationT::Factor;
  using Factors = typename PropagationT::template Factors<K>;
  using Landmarks = LandmarksT;
  using Window = pl::FrameWindow<S, Layout, K>;
  struct Options {  // reached as `options.backend`
    int iterations = 4;
    double mu = 1e-4;  ///< damping of the first step
  };

  StructureBackend(const Options& options, const typename PropagationT::Options& propagation)
      : options_(options), factors_(propagation) {}

  const Window& window() const { return window_; }
  Window& window() { return window_; }
  const Factors& factors() const { return factors_; }

  /// Clears everything; one frame, which is the origin of the world.
  int start(pl::TimeNs t_ns, const State& x) {
    window_.clear();
    covariance_.setZero();
    return insert(t_ns, x, {});
  }
  int insert(pl::TimeNs t_ns, const State& x, const Factor&) {
    before_ = window_.size() > 0 ? window_.newest() : none;
    return window_.insert(t_ns, x);
  }
  void drop(Landmarks& landmarks, int slot) {
    landmarks.for_each([&](auto& store) { store.remove_frame(slot); });
    window_.remove(slot);
  }

  /// The landmarks, all frames being given. `WindowTerms` has their rows and eliminates them one by one; a step of
  /// the frames that is zero leaves each of them its own.
  void optimize(const Sensors& rig, const pl::SE3<S>& T_body_cam, Landmarks& landmarks, bool /*keyframe*/ = true) {
    views_.update(window_, T_body_cam);
    views_.set_transports(window_, pairs_);
    const pl::Vec<double, K* Layout::dim> no_step = pl::Vec<double, K * Layout::dim>::Zero();
    double mu = options_.mu;
    for (int iteration = 0; iteration < options_.iterations; ++iteration) {
      const double cost = linearize(rig, landmarks);
      if (!eliminate(landmarks, mu)) break;
      double moved = 0;
      landmarks.for_each_with(terms_, [&](auto& store, auto& terms) {
        terms.solve(store, pairs_, no_step, Layout::dim);
        terms.step(store);
        moved += terms.cost(rig, store, window_, views_);
      });
      mu *= moved < cost ? 0.1 : 10;
      if (!(moved < cost)) landmarks.for_each_with(terms_, [](auto& store, auto& terms) { terms.restore(store); });
    }
    pairs_.reset();
    landmarks.for_each_with(terms_,
                            [&](auto& store, auto& terms) { terms.finish(rig, store, window_, views_, pairs_); });
    grow_covariance(landmarks);
  }

  /// A frame as the map gets it.
  pl::Retired<State, Landmarks> retired(int slot, const Landmarks& landmarks) const {
    return {slot, window_, landmarks};
  }
  /// A frame leaves without a trace but what the map keeps of it.
  void retire(const Sensors&, const pl::SE3<S>&, Landmarks& landmarks, int slot, auto& map) {
    map.on_retired(retired(slot, landmarks));
    drop(landmarks, slot);
  }

  bool covariance_of_newest(pl::Mat<S, 6, 6>& covariance) const {
    covariance = covariance_;
    return true;
  }

 private:
  static constexpr int none = -1;
  template <class Store>
  using Terms = pl::WindowTerms<Store>;

  double linearize(const Sensors& rig, const Landmarks& landmarks) {
    double cost = 0;
    pairs_.reset();
    landmarks.for_each_with(
        terms_, [&](auto& store, auto& terms) { cost += terms.linearize(rig, store, window_, views_, pairs_); });
    return cost;
  }
  bool eliminate(const Landmarks& landmarks, double mu) {
    equations_.reset(K);
    pairs_.add_to(equations_);
    bool eliminated = true;
    landmarks.for_each_with(terms_, [&](auto& store, auto& terms) {
      eliminated = eliminated && terms.eliminate(store, S(mu), pairs_, equations_);
    });
    return eliminated;
  }

  /// The covariance of the newest keyframe is relative to the one before it, as the landmarks relate it to all others.
  void grow_covariance(const Landmarks& landmarks) {
    const int newest = window_.newest();
    if (before_ == none || before_ == newest) return;
    if (!eliminate(landmarks, 1e-9)) return;
    const pl::Mat<double, 6, 6> fixed = 1e12 * pl::Mat<double, 6, 6>::Identity();
    for (int k = 0; k < K; ++k) {
      if (k != newest) equations_.add_block(k, k, fixed);
    }
    pl::Mat<double, 6, 6> relative;
    if (!equations_.covariance_block(newest, relative)) return;
    const pl::Mat<S, 6, 6> Ad = (window_.T_world_body(newest).inverse() * window_.T_world_body(before_)).adjoint();
    covariance_ = Ad * covariance_ * Ad.transpose() + relative.template cast<S>();
    before_ = none;
  }

  Options options_;
  Window window_;
  [[no_unique_address]] Factors factors_;
  pl::WindowViews<S, K> views_;
  pl::NormalEquations<double, Layout::dim, K> equations_;
  pl::RelativeEquations<double, Layout::dim, K> pairs_;
  typename Landmarks::template TupleOf<Terms> terms_;
  pl::Mat<S, 6, 6> covariance_ = pl::Mat<S, 6, 6>::Zero();
  int before_ = none;  ///< slot of the keyframe before the newest, until that is counted
};

/// The policy: how many keyframes, and which front ends.
template <int K, class FrontEndPolicy = pl::Flow>
struct StructureOnly {
  static constexpr int slots = K;
  using FrontEnds = FrontEndPolicy;
  template <pl::Propagation PropagationT, class Landmarks>
  using Backend = StructureBackend<PropagationT, Landmarks, K>;
};

int main() {
  constexpr int width = 320, height = 240;
  using Sensors = pl::Rig<pl::Rgbd<pl::Pinhole<double>, width * height>>;
  using Vo = pl::Estimator<Sensors, pl::Features<pl::Points<200>, pl::Lines<50>>, StructureOnly<6>>;
  static_assert(pl::Backend<Vo::Backend>);

  Sensors sensors{};
  sensors.vision.camera = {268, 268, 159.5, 119.5, {}};
  sensors.vision.width = width;
  sensors.vision.height = height;
  const auto vo = std::make_unique<Vo>(sensors);

  const pl::testing::RoomRun run = pl::testing::run_in_room(*vo);
  const double sigma_m = std::sqrt(vo->latest().covariance.bottomRightCorner<3, 3>().trace());
  std::printf("%.2f m traveled, at most %.1f cm off, %.1f cm claimed\n", run.path_m, 100 * run.error_m, 100 * sigma_m);
  return run.is_within(0.03) ? 0 : 1;
}
