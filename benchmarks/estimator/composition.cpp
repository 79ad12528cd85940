// The composed estimator against the same loop written by hand: a camera with depth in a rendered room, frame by frame
// in turn. The program fails unless both give the same poses and covariances to the last bit.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "plumbline/backend/keyframe_rule.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/feature/pose_refinement.hpp"
#include "plumbline/frontend/point_flow.hpp"
#include "plumbline/geometry/pose_ransac.hpp"
#include "plumbline/map/no_map.hpp"
#include "plumbline/propagation/constant_velocity.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/state/world_frame_uncertainty.hpp"
#include "plumbline/testing/rig.hpp"
#include "plumbline/testing/scenes.hpp"
#include "plumbline/testing/simulated_camera.hpp"
#include "plumbline/testing/trajectory.hpp"
#include "plumbline/tracking/rotation_alignment.hpp"

namespace plumbline {
namespace {

using S = float;
constexpr int width = 320, height = 240, points = 180, keyframes = 7;
using Camera = Pinhole<S>;
using Sensors = Rig<Rgbd<Camera, width * height, Global>>;
using Composed = Estimator<Sensors, Features<Points<points>>, SlidingWindow<keyframes>>;

/// The same estimator written by hand, without composition.
class ByHand {
 public:
  explicit ByHand(const Sensors& sensors) : rig_(sensors), T_body_cam_(sensors.T_body_cam()) {}

  const SE3<S>& T_world_body() const { return T_world_body_; }
  const Mat<S, 6, 6>& covariance() const { return covariance_; }

  bool add_frame(const Sensors::Frame& frame) {
    if (!pyramids_[1 - kept_].build(frame.gray)) return false;
    const View<Sensors> view{frame.t_ns,
                             S(seconds_between(t_ns_, frame.t_ns)),
                             rig_,
                             pyramids_[kept_],
                             pyramids_[1 - kept_],
                             frame.depth,
                             T_world_kept_,
                             T_body_cam_,
                             {rig_.vision.camera, height, S(0)}};
    t_ns_ = frame.t_ns;
    if (!begun_) return begin(view);

    const SE3<S> T_predicted = predict(view);
    SE3<S> T = T_predicted;
    store().begin_frame();
    flow_.follow(view, window(), store(), T);
    consensus(view, T);

    Mat<S, 6, 6> covariance;
    const auto refine = [&] {
      return pose_.refine(rig_, T_body_cam_, landmarks_, window(), T_predicted, {}, T, covariance) ==
             HealthReason::none;
    };
    if (!refine() || !refine()) return false;
    flow_.refine(view, window(), store(), T);
    if (!refine()) return false;
    velocity_ = minus(T, T_world_kept_) / view.dt;

    window().set_latest({T});
    keep(view, T);
    origin_.move_to(T);
    const Mat<S, 6, 6> Ad = (T.inverse() * window().T_world_body(keyframe_)).adjoint();
    const Mat<S, 6, 6> of_frame = Ad * keyframe_covariance_ * Ad.transpose() + covariance;
    covariance_ = of_frame + origin_.at(T);
    flow_.locate(view, window(), store(), T);
    store().prune();
    if (needs_keyframe()) make_keyframe(view);
    return true;
  }

 private:
  using Landmarks = Composed::Landmarks;
  using Store = std::remove_cvref_t<decltype(std::declval<Landmarks&>().get<0>())>;
  static constexpr std::size_t thumbnail_pixels = (width * height) >> (2 * RigPyramid<Sensors>::levels);

  Store& store() { return landmarks_.get<0>(); }
  Composed::Backend::Window& window() { return backend_.window(); }

  bool begin(const View<Sensors>& view) {
    begun_ = true;
    store().clear();
    const int slot = backend_.start(view.t_ns, window().latest());
    window().set_latest(slot);
    detect(view, slot);
    adopt(view, slot);
    return store().tracked_count() >= 15;
  }

  /// Constant velocity, its rotation by the thumbnails; without its translation where they fit better so.
  SE3<S> predict(const View<Sensors>& view) {
    const SE3<S> latest = window().latest().T_world_body;
    SE3<S> T = latest;
    if (view.dt < S(0.5)) T = plus(T, Vec<S, 6>(velocity_ * view.dt));
    const SE3<S> T_world_previous = latest * T_body_cam_;
    const SE3<S> guess = (T * T_body_cam_).inverse() * T_world_previous;
    const Vec<S, 3> parallax = guess.p() / mean_depth();
    thumbnail_.build(view.previous);
    rotation_.set_previous(rig_.vision.camera, thumbnail_);
    thumbnail_.build(view.current);
    const auto align = [&](const SO3<S>& R, const Vec<S, 3>& q) {
      return rotation_.align(rig_.vision.camera, thumbnail_, R, q, rotation_options_);
    };
    const RotationAlignment<S> moved = align(guess.rotation(), parallax);
    const RotationAlignment<S> still = align(SO3<S>(), Vec<S, 3>::Zero());
    if (!still.valid && !moved.valid) return T;
    const bool is_stationary = still.valid && (!moved.valid || still.cost < moved.cost);
    const SO3<S> R_world_cam = T_world_previous.rotation() * (is_stationary ? still : moved).R_cur_prev.inverse();
    return SE3<S>(R_world_cam * T_body_cam_.rotation().inverse(), is_stationary ? latest.p() : T.p());
  }

  void consensus(const View<Sensors>& view, SE3<S>& T) {
    correspondences_.clear();
    candidates_.clear();
    flow_.for_each_correspondence(view, window(), store(), [&](int index, const PoseCorrespondence<S>& correspondence) {
      correspondences_.push_back(correspondence);
      candidates_.push_back(index);
    });
    const auto found = ransac_pose(correspondences_, (T * T_body_cam_).inverse(), PoseRansacOptions{});
    if (!found.valid) return;
    T = (T_body_cam_ * found.T_cam_world).inverse();
    for (std::size_t k = 0; k < correspondences_.size(); ++k) {
      if (!found.inlier[k]) store().reject(candidates_[k]);
    }
  }

  bool needs_keyframe() {
    double sum_px = 0;
    int count = 0;
    store().add_motion_since(keyframe_, 1e9, sum_px, count);
    const double moved_px = count > 0 ? sum_px / count : 0;
    return rule_.is_keyframe(store().tracked_count(), tracked_at_keyframe_,
                             moved_px / double(effective_focal_length(rig_.vision.camera)));
  }

  void make_keyframe(const View<Sensors>& view) {
    const int slot = backend_.insert(view.t_ns, window().latest(), {});
    detect(view, slot);
    backend_.optimize(rig_, T_body_cam_, landmarks_);
    window().set_latest(slot);
    adopt(view, slot);
    if (!window().full()) return;
    backend_.retire(rig_, T_body_cam_, landmarks_, window().oldest(), map_);
  }
  S mean_depth() {
    S inverse_sum = S(0);
    int count = 0;
    store().add_inverse_ranges(inverse_sum, count);
    return count > 0 ? S(count) / inverse_sum : S(1);
  }

  void detect(const View<Sensors>& view, int slot) {
    store().record(slot);
    flow_.detect(view, window(), store(), slot);
  }
  /// The last keyframe is the one in `slot`, the latest frame.
  void adopt(const View<Sensors>& view, int slot) {
    keep(view, window().latest().T_world_body);
    keyframe_ = slot;
    tracked_at_keyframe_ = store().tracked_count();
    if (backend_.covariance_of_newest(keyframe_covariance_)) {
      covariance_ = keyframe_covariance_ + origin_.at(T_world_body_);
    }
  }
  void keep(const View<Sensors>& view, const SE3<S>& T) {
    kept_ = &view.current == &pyramids_[0] ? 0 : 1;
    T_world_kept_ = T_world_body_ = T;
  }

  const Sensors rig_;
  const SE3<S> T_body_cam_;
  RigPyramid<Sensors> pyramids_[2];
  Thumbnail<thumbnail_pixels> thumbnail_;
  RotationAligner<Camera, thumbnail_pixels> rotation_;
  const RotationAlignmentOptions rotation_options_;
  Landmarks landmarks_{StoreOptions{}};
  PointFlow<Store> flow_{PointFlowOptions{}};
  PoseRefinement<Sensors, Landmarks> pose_{PoseRefinementOptions{}};
  Composed::Backend backend_{{}, {}};
  KeyframeRule rule_{default_keyframes<Sensors>()};
  NoMap::Discard<S> map_;
  FixedVector<PoseCorrespondence<S>, points> correspondences_;
  FixedVector<int, points> candidates_;
  bool begun_ = false;
  TimeNs t_ns_ = 0;
  int kept_ = 0, keyframe_ = 0, tracked_at_keyframe_ = 0;
  SE3<S> T_world_kept_, T_world_body_;
  WorldFrameUncertainty<S> origin_{S(0.002)};
  Vec<S, 6> velocity_ = Vec<S, 6>::Zero();
  Mat<S, 6, 6> covariance_, keyframe_covariance_ = Mat<S, 6, 6>::Zero();
};

struct Recording {
  Sensors rig{};
  std::vector<testing::SimulatedCamera::Frame> frames;

  explicit Recording(int count) {
    rig.vision.camera = {268, 268, 159.5f, 119.5f, {}};
    rig.vision.width = width;
    rig.vision.height = height;
    const testing::Trajectory trajectory = *testing::Trajectory::for_scene("room");
    const testing::Renderer renderer(*testing::make_scene("room"), rig.vision.camera, width, height, 2);
    testing::SimulatedCamera camera(renderer, testing::simulated_T_body_camera(), {}, /*seed=*/1);
    for (int i = 0; i < count; ++i) frames.push_back(camera.frame(trajectory, 2 + i / 20.0, std::uint64_t(i)));
  }
  Sensors::Frame frame(std::size_t i) const {
    return {TimeNs(2e9 + 5e7 * double(i)), frames[i].gray.view(), frames[i].depth.view()};
  }
};

double seconds(auto&& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}
double median(std::vector<double> x) {
  std::nth_element(x.begin(), x.begin() + std::ptrdiff_t(x.size() / 2), x.end());
  return x[x.size() / 2];
}

}  // namespace
}  // namespace plumbline

int main(int argc, char** argv) {
  using namespace plumbline;
  const int runs = argc > 1 ? std::atoi(argv[1]) : 31, count = 80;
  const Recording recording(count);
  std::vector<std::vector<double>> composed_s(count), by_hand_s(count);
  int keyframe_count = 0;
  for (int run = 0; run < runs; ++run) {
    const auto composed = std::make_unique<Composed>(recording.rig);
    const auto by_hand = std::make_unique<ByHand>(recording.rig);
    for (std::size_t i = 0; i < std::size_t(count); ++i) {
      const Sensors::Frame frame = recording.frame(i);
      bool good = true;
      const auto add_composed = [&] { good = bool(composed->add_frame(frame)) && good; };
      const auto add_by_hand = [&] { good = by_hand->add_frame(frame) && good; };
      const bool first = (run + int(i)) % 2 == 0;
      if (first) composed_s[i].push_back(seconds(add_composed));
      by_hand_s[i].push_back(seconds(add_by_hand));
      if (!first) composed_s[i].push_back(seconds(add_composed));
      const Estimate<S>& estimate = composed->latest();
      keyframe_count += run == 0 && estimate.keyframe;
      const SE3<S>&a = estimate.T_world_body, &b = by_hand->T_world_body();
      if (!good || estimate.health.state != HealthState::tracking || a.p() != b.p() ||
          a.rotation().quaternion().coeffs() != b.rotation().quaternion().coeffs() ||
          estimate.covariance != by_hand->covariance()) {
        std::printf("frame %zu: the loop written by hand does something else\n", i);
        return 1;
      }
    }
  }
  double composed = 0, by_hand = 0;
  for (std::size_t i = 0; i < std::size_t(count); ++i) {
    composed += median(composed_s[i]);
    by_hand += median(by_hand_s[i]);
  }
  std::printf("%d frames, %d keyframes, %d runs in turn; the same to the last bit\n", count, keyframe_count, runs);
  std::printf("composed %.4f ms, by hand %.4f ms a frame (medians): ratio %.4f\n", 1e3 * composed / count,
              1e3 * by_hand / count, composed / by_hand);
}
