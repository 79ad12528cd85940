#pragma once
/// Backend: every frame alone against the map, and a local bundle of the last K keyframes when one is made.
///                                                                                          docs/math/direct.md
/// A frame is the least that its images and links say: its pose, and with an IMU its velocity and biases, tied to the
/// last keyframe (FrameSolve). Keyframes and landmarks are estimated together by a few steps of Gauss-Newton, and
/// keyframes that leave are marginalized (WindowBackend), so that neither scale nor gravity drifts. By default features
/// are found by direct alignment.

#include "plumbline/backend/backend.hpp"
#include "plumbline/backend/frame_solve.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/frontend/direct_alignment.hpp"
#include "plumbline/motion/motion_model.hpp"
#include "plumbline/solver/levenberg_marquardt.hpp"

namespace plumbline {

struct DirectOptions : WindowOptions {
  DirectOptions() { solver.max_iterations = 5; }  // a bundle of keyframes
  FrameSolveOptions frame;
};

template <MotionModel Motion, class LandmarksT, int K>
class DirectBackend {
 public:
  using Bundle = WindowBackend<Motion, LandmarksT, K>;
  using Sensors = typename Bundle::Sensors;
  using S = typename Bundle::S;
  using Layout = typename Bundle::Layout;
  using State = typename Bundle::State;
  using Link = typename Bundle::Link;
  using Links = typename Bundle::Links;
  using Landmarks = LandmarksT;
  using Window = typename Bundle::Window;
  using Options = DirectOptions;

  DirectBackend(const Options& options, const typename Motion::Options& motion)
      : options_(options), bundle_(options, motion) {}

  const Window& window() const { return bundle_.window(); }
  Window& window() { return bundle_.window(); }
  const Links& links() const { return bundle_.links(); }

  void believe_readout(double value_s, double sigma_s) { bundle_.believe_readout(value_s, sigma_s); }
  void set_readout(double value_s) { bundle_.set_readout(value_s); }
  bool find_readout(const Sensors& rig, const SE3<S>& T_body_cam, Landmarks& landmarks,
                    ReadoutCorrection& out) requires Sensors::rolls {
    return bundle_.find_readout(rig, T_body_cam, landmarks, out);
  }

  int start(TimeNs t_ns, const State& x) {
    alone_ = false;
    const int slot = bundle_.start(t_ns, x);
    know_keyframe();
    return slot;
  }
  template <int Rows>
  void restart(auto&& state_of, const Mat<double, Rows, Layout::dim>& J_rest, const SE3<S>& T_body_cam,
               const ClockBelief& clock = {}) {
    bundle_.restart(state_of, J_rest, T_body_cam, clock);
  }
  void hold_distance(int i, int j, double distance, double sigma) { bundle_.hold_distance(i, j, distance, sigma); }
  void hold_scale(int i, int j) { bundle_.hold_scale(i, j); }
  int insert(TimeNs t_ns, const State& x, const Link& link) {
    if constexpr (requires { link.previous; }) frame_.follow(window(), links(), link.previous, options_.frame);
    return bundle_.insert(t_ns, x, link);
  }
  void drop(Landmarks& landmarks, int slot) {
    frame_.forget(slot);
    bundle_.drop(landmarks, slot);
  }

  /// The bundle of all keyframes, or the newest frame alone when it is none.
  void optimize(const Sensors& rig, const SE3<S>& T_body_cam, Landmarks& landmarks, bool keyframe = true) {
    alone_ = frame_.solve(rig, T_body_cam, landmarks, window(), links(), window().newest(), options_.frame);
    bundle_.links().set_judged(window().newest(), keyframe);
    if (keyframe) optimize(rig, T_body_cam, landmarks, options_.solver);
  }
  LevenbergMarquardtSummary optimize(const Sensors& rig, const SE3<S>& T_body_cam, Landmarks& landmarks,
                                     const LevenbergMarquardtOptions& solver) {
    const LevenbergMarquardtSummary summary = bundle_.optimize(rig, T_body_cam, landmarks, solver);
    alone_ = false;
    know_keyframe();
    return summary;
  }

  void retire(const Sensors& rig, const SE3<S>& T_body_cam, Landmarks& landmarks, int slot, auto& map) {
    bundle_.retire(rig, T_body_cam, landmarks, slot, map);
  }

  /// Of the newest frame's pose; false when it is not defined.
  bool covariance_of_newest(Mat<S, state::Pose::dim, state::Pose::dim>& covariance) const {
    if (!alone_) return bundle_.covariance_of_newest(covariance);
    return frame_.covariance(window(), window().newest(), covariance);
  }
  /// Of the leading blocks of the newest keyframe, which was solved for with the bundle.
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
  void know_keyframe() {
    Mat<S, Layout::dim, Layout::dim> covariance = zeros<S, Layout::dim, Layout::dim>();
    bundle_.covariance_of_newest(covariance);
    frame_.set_keyframe(window().newest(), covariance);
  }

  Options options_;
  Bundle bundle_;
  FrameSolve<Motion, Landmarks> frame_;
  bool alone_ = false;  ///< the newest frame was solved for alone
};

/// The last `Keyframes` keyframes; FrontEndPolicy finds their landmarks.
template <int Keyframes = 10, class FrontEndPolicy = DirectAlignment>
struct DirectGaussNewton {
  static_assert(Keyframes >= 3, "plumbline: a bundle needs at least three keyframes");
  static constexpr int slots = Keyframes;
  using FrontEnds = FrontEndPolicy;

  template <MotionModel Motion, class Landmarks>
  using Backend = DirectBackend<Motion, Landmarks, Keyframes>;
};

}  // namespace plumbline
