#pragma once
/// Backend: every frame alone against the local map, and a bundle adjustment of the last K keyframes when one is added.
///                                                                                          docs/math/direct.md
/// The state of a frame (pose; velocity and biases with an IMU) minimizes the terms of its features and of its factor
/// to the last keyframe, landmarks fixed (FrameSolve). Keyframes and landmarks are estimated together by a few
/// iterations, and keyframes that leave are marginalized (WindowBackend), which limits the drift of scale and gravity
/// direction. Its default front ends are those of direct alignment.

#include "plumbline/backend/backend.hpp"
#include "plumbline/backend/frame_solve.hpp"
#include "plumbline/backend/window_backend.hpp"
#include "plumbline/backend/window_options.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/factor/frame_factors.hpp"
#include "plumbline/frontend/direct_alignment.hpp"
#include "plumbline/propagation/propagation.hpp"
#include "plumbline/solver/levenberg_marquardt.hpp"

namespace plumbline {

struct DirectOptions : WindowOptions {
  DirectOptions() { solver.max_iterations = 5; }  // of the bundle adjustment of keyframes; tuned: docs/decisions/085
  FrameSolveOptions frame;
};

template <Propagation PropagationT, class LandmarksT, int K, class FrameFactorsT = NoFrameFactors>
class DirectBackend {
 public:
  using Bundle = WindowBackend<PropagationT, LandmarksT, K, FrameFactorsT>;
  using Sensors = typename Bundle::Sensors;
  using S = typename Bundle::S;
  using Layout = typename Bundle::Layout;
  using State = typename Bundle::State;
  using Factor = typename Bundle::Factor;
  using Factors = typename Bundle::Factors;
  using FrameFactors = FrameFactorsT;
  using Landmarks = LandmarksT;
  using Window = typename Bundle::Window;
  using Options = DirectOptions;

  DirectBackend(const Options& options, const typename PropagationT::Options& propagation)
      : options_(options), bundle_(options, propagation) {}

  const Window& window() const { return bundle_.window(); }
  Window& window() { return bundle_.window(); }
  const Factors& factors() const { return bundle_.factors(); }
  const FrameFactors& frame_factors() const { return bundle_.frame_factors(); }

  void set_readout_prior(double value_s, double sigma_s) { bundle_.set_readout_prior(value_s, sigma_s); }
  void set_readout(double value_s) { bundle_.set_readout(value_s); }
  bool find_readout(const Sensors& rig, const SE3<S>& T_body_cam, Landmarks& landmarks,
                    ReadoutCorrection& out) requires Sensors::rolls {
    return bundle_.find_readout(rig, T_body_cam, landmarks, out);
  }

  int start(TimeNs t_ns, const State& x) {
    solved_alone_ = false;
    const int slot = bundle_.start(t_ns, x);
    update_keyframe_covariance();
    return slot;
  }
  template <int Rows>
  void restart(auto&& state_of, const Mat<double, Rows, Layout::dim>& J_prior, const SE3<S>& T_body_cam,
               const TimeOffsetEstimate& time_offset = {}) {
    bundle_.restart(state_of, J_prior, T_body_cam, time_offset);
  }
  void hold_distance(int i, int j, double distance, double sigma) { bundle_.hold_distance(i, j, distance, sigma); }
  void hold_scale(int i, int j) { bundle_.hold_scale(i, j); }
  int insert(TimeNs t_ns, const State& x, const Factor& factor) {
    if constexpr (requires { factor.previous; })
      frame_.set_reference(window(), factors(), factor.previous, options_.frame);
    return bundle_.insert(t_ns, x, factor);
  }
  template <class G>
  bool add_factor(int slot, const G& factor) requires FrameFactorsT::template takes<G> {
    return bundle_.add_factor(slot, factor);
  }
  void drop(Landmarks& landmarks, int slot) {
    frame_.discard(slot);
    bundle_.drop(landmarks, slot);
  }

  /// Bundle adjustment of all keyframes, or the solution of the newest frame alone when it is no keyframe.
  void optimize(const Sensors& rig, const SE3<S>& T_body_cam, Landmarks& landmarks, bool keyframe = true) {
    solved_alone_ = frame_.solve(rig, T_body_cam, landmarks, window(), factors(), window().newest(), options_.frame,
                                 frame_factors());
    bundle_.factors().set_checked(window().newest(), keyframe);
    if (keyframe) optimize(rig, T_body_cam, landmarks, options_.solver);
  }
  LevenbergMarquardtSummary optimize(const Sensors& rig, const SE3<S>& T_body_cam, Landmarks& landmarks,
                                     const LevenbergMarquardtOptions& solver) {
    const LevenbergMarquardtSummary summary = bundle_.optimize(rig, T_body_cam, landmarks, solver);
    solved_alone_ = false;
    update_keyframe_covariance();
    return summary;
  }

  auto retired(int slot, const Landmarks& landmarks) const { return bundle_.retired(slot, landmarks); }
  void retire(const Sensors& rig, const SE3<S>& T_body_cam, Landmarks& landmarks, int slot, auto& map) {
    bundle_.retire(rig, T_body_cam, landmarks, slot, map);
  }

  /// Covariance of the pose of the newest frame [rad, m]; false when it is not defined.
  bool covariance_of_newest(Mat<S, state::Pose::dim, state::Pose::dim>& covariance) const {
    if (!solved_alone_) return bundle_.covariance_of_newest(covariance);
    return frame_.covariance(window(), window().newest(), covariance);
  }
  /// Covariance of the leading blocks of the newest keyframe by the last bundle adjustment.
  template <int Dim>
  bool covariance_of_keyframe(Mat<S, Dim, Dim>& covariance) const {
    return bundle_.covariance_of_newest(covariance);
  }
  bool covariance_of_extrinsics(Mat<double, 6, 6>& covariance) const requires has_extrinsics<Layout> {
    return bundle_.covariance_of_extrinsics(covariance);
  }
  bool sigma_of_time_offset(double& sigma_s) const requires has_time_offset<Layout> {
    return bundle_.sigma_of_time_offset(sigma_s);
  }

 private:
  void update_keyframe_covariance() {
    Mat<S, Layout::dim, Layout::dim> covariance = zeros<S, Layout::dim, Layout::dim>();
    bundle_.covariance_of_newest(covariance);
    frame_.set_keyframe(window().newest(), covariance);
  }

  Options options_;
  Bundle bundle_;
  FrameSolve<PropagationT, Landmarks> frame_;
  bool solved_alone_ = false;  ///< the newest frame has a solution by FrameSolve
};

/// Backend policy: `Keyframes` is the size of the bundle, FrontEndPolicy names the front end of each feature kind,
/// FactorTypes the factors that can be attached to frames.
template <int Keyframes = 10, class FrontEndPolicy = DirectAlignment, template <class> class... FactorTypes>
struct DirectGaussNewton {
  static_assert(Keyframes >= 3, "plumbline: a bundle needs at least three keyframes");
  static constexpr int slots = Keyframes;
  using FrontEnds = FrontEndPolicy;

  template <Propagation PropagationT, class Landmarks>
  using Backend = DirectBackend<PropagationT, Landmarks, Keyframes,
                                FrameFactorsOf<typename PropagationT::S, Keyframes, FactorTypes...>>;
};

}  // namespace plumbline
