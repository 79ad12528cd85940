// An estimator from archetypes: policies that have nothing but what their concepts list, each around one of the
// library. A call that its concept does not list does not compile.
#include <concepts>
#include <memory>
#include <utility>

#include "catch.hpp"
#include "estimator/simulation.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/frontend/point_flow.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/testing/simulated_imu.hpp"

using namespace plumbline;

namespace {

constexpr int slots = 4, pixels = test::SimulatedRgbd::width * test::SimulatedRgbd::height;

// Rigs of their own, whose propagation and initializer are the archetypes.
struct RgbdRig : Rig<Rgbd<Pinhole<double>, pixels>> {};
struct MonoImuRig : Rig<Mono<Pinhole<double>, pixels>, Imu> {};

/// Neither copied nor moved.
struct Pinned {
  Pinned() = default;
  Pinned(const Pinned&) = delete;
  Pinned& operator=(const Pinned&) = delete;
};

/// What a policy of every rig has; `Inner` does the work.
template <class SensorsT, class Inner>
class BarePropagation : Pinned {
 public:
  using Sensors = SensorsT;
  using S = double;
  using State = typename Inner::State;
  using Layout = typename Inner::Layout;
  using Factor = typename Inner::Factor;
  using Options = typename Inner::Options;
  template <int Slots>
  using Factors = typename Inner::template Factors<Slots>;
  static constexpr bool has_imu_factors = Sensors::has_imu;
  using Frames = FrameWindow<S, Layout, slots>;
  using Predicted = Prediction<State, S>;

  BarePropagation(const Sensors& rig, const Options& options) : inner(rig, options) {}

  void calibrate(RigState<Sensors>& rig_state, const Frames& frames) { inner.calibrate(rig_state, frames); }
  void begin_frame(TimeNs t_ns, const State* latest, S dt) { inner.begin_frame(t_ns, latest, dt); }
  SE3<S> T_body_cam(const SE3<S>& extrinsics) const { return inner.T_body_cam(extrinsics); }
  Predicted predict(const State& latest, const View<Sensors>& view, S outage_s, auto&& align_motion) {
    return inner.predict(latest, view, outage_s, align_motion);
  }
  bool can_propagate() const { return inner.can_propagate(); }
  Mat<S, 6, 6> grown_covariance(const Mat<S, 6, 6>& before, S outage_s) const {
    return inner.grown_covariance(before, outage_s);
  }
  State restart(const State& x) { return inner.restart(x); }
  void mark_lost() { inner.mark_lost(); }

  bool passes_gate(const Predicted& predicted, const SE3<S>& T) const { return inner.passes_gate(predicted, T); }
  bool contradicts(const Predicted& predicted, const SE3<S>& T) const { return inner.contradicts(predicted, T); }
  State update(const State& predicted, const SE3<S>& T, const Mat<S, 6, 6>& covariance, const View<Sensors>& view) {
    return inner.update(predicted, T, covariance, view);
  }
  bool correct(const State& before, State& solved, S dt) const { return inner.correct(before, solved, dt); }
  S gyro_jump_rotation() const { return inner.gyro_jump_rotation(); }
  HealthReason diagnose(const Factors<slots>& factors, const Frames& frames, bool few) {
    return inner.diagnose(factors, frames, few);
  }
  bool is_inconsistent() const { return inner.is_inconsistent(); }

  bool is_initialized() const { return inner.is_initialized(); }
  bool is_stationary() const { return inner.is_stationary(); }
  bool can_be_stationary(TimeNs t_ns) { return inner.can_be_stationary(t_ns); }
  bool confirm_keyframe(TimeNs t_ns, auto&& motion_px, bool needed) {
    return inner.confirm_keyframe(t_ns, motion_px, needed);
  }
  Factor factor(int slot) const { return inner.factor(slot); }
  void begin_factor() { inner.begin_factor(); }

 protected:
  Inner inner;
};

/// And what a rolling shutter adds.
template <class SensorsT, class Inner>
class BareRollingPropagation : public BarePropagation<SensorsT, Inner> {
  using Base = BarePropagation<SensorsT, Inner>;
  using Base::inner;

 public:
  using Base::Base;
  Vec<double, 3> angular_rate() const { return inner.angular_rate(); }
  Vec<double, 3> velocity(const typename Base::State& x) const { return inner.velocity(x); }
};

/// And what an IMU, and the absence of depth, add.
template <class SensorsT, class Inner>
class BareImuPropagation : public BarePropagation<SensorsT, Inner> {
  using Base = BarePropagation<SensorsT, Inner>;
  using Base::inner;

 public:
  using S = double;
  using Base::Base;
  using Covariance = Mat<S, MovingLayout::dim, MovingLayout::dim>;

  bool detect_stationarity(TimeNs t_ns, double motion_px) { return inner.detect_stationarity(t_ns, motion_px); }
  ImuIntegrator<S>& imu() { return inner.imu(); }
  const ImuIntegrator<S>& imu() const { return inner.imu(); }
  const CameraImuFilter& camera_imu() const { return inner.camera_imu(); }
  const typename Base::Options& options() const { return inner.options(); }
  typename Base::State stationary_state() const { return inner.stationary_state(); }
  TimeOffsetEstimate time_offset(double converged_sigma_s) const { return inner.time_offset(converged_sigma_s); }
  void adopt_time_offset(const typename Base::Frames& frames) { inner.adopt_time_offset(frames); }
  void set_initialized() { inner.set_initialized(); }
  void set_velocity_covariance(const Covariance& P) { inner.set_velocity_covariance(P); }
  void set_speed_covariance(const Covariance& P, const Vec<S, 3>& v) { inner.set_speed_covariance(P, v); }
  double speed() const { return inner.speed(); }
  double speed_sigma() const { return inner.speed_sigma(); }
};

/// With depth and without IMU nothing is asked.
struct NoInitializer : Pinned {
  static constexpr bool needs_second_view = false;
  struct Options {};
  explicit NoInitializer(const Options&) {}
};

/// Two views, then vision and IMU.
class BareInitializer : Pinned {
  using S = double;
  using Inner = InertialInitializer<S, TwoViewInitializer<S, GuidedTwoView>>;

  class Views : Pinned {
   public:
    explicit Views(Inner::Visual& views) : views_(views) {}
    void clear_pairs() { views_.clear_pairs(); }
    void add_pair(const Vec<S, 3>& f1, const Vec<S, 3>& f2) { views_.add_pair(f1, f2); }
    int pairs() const { return views_.pairs(); }
    bool has_expired(double age_s) const { return views_.has_expired(age_s); }
    bool solve(const SO3<S>& R_2_1, InitReport& report) { return views_.solve(R_2_1, report); }
    SE3<S> T_1_2(S distance) const { return views_.T_1_2(distance); }

   private:
    Inner::Visual& views_;
  };

 public:
  static constexpr bool needs_second_view = true;
  using Options = Inner::Options;
  explicit BareInitializer(const Options& options) : inner_(options) {}

  Views& visual() { return views_; }
  const Options& options() const { return inner_.options(); }
  void clear() { inner_.clear(); }
  bool add(TimeNs t_ns, const SE3<S>& T, const Mat<S, 3, 3>& covariance, const Preintegration<S>& samples,
           const RigState<MonoImuRig>& rig_state) {
    return inner_.add(t_ns, T, covariance, samples, rig_state);
  }
  void correct(TimeNs t_ns, const SE3<S>& T) { inner_.correct(t_ns, T); }
  bool align(const SE3<S>& T, double gravity, InitReport& report) { return inner_.align(T, gravity, report); }
  bool is_contradicted() const { return inner_.is_contradicted(); }
  bool is_time_offset_known(const CameraImuFilter& filter, double age_s) const {
    return inner_.is_time_offset_known(filter, age_s);
  }
  bool verify_time_offset(double offset_s) { return inner_.verify_time_offset(offset_s); }
  bool is_plausible(const NavState<S>& x) const { return inner_.is_plausible(x); }
  bool has_estimate() const { return inner_.has_estimate(); }
  S scale() const { return inner_.scale(); }
  double scale_sigma() const { return inner_.scale_sigma(); }
  double gravity_sigma() const { return inner_.gravity_sigma(); }
  Vec<S, 3> latest_velocity() const { return inner_.latest_velocity(); }
  NavState<S> state_of(const SE3<S>& T_ref, const SE3<S>& T_body_cam) const {
    return inner_.state_of(T_ref, T_body_cam);
  }
  Mat<double, 6, InertialLayout::dim> prior_on_biases() const { return inner_.prior_on_biases(); }

 private:
  Inner inner_;
  Views views_{inner_.visual()};
};

/// What a backend has for a camera with depth.
template <class PropagationT, class LandmarksT>
class BareBackend : Pinned {
 protected:
  using Inner = WindowBackend<PropagationT, LandmarksT, slots>;
  Inner inner;

 public:
  using Sensors = typename Inner::Sensors;
  using S = typename Inner::S;
  using Layout = typename Inner::Layout;
  using State = typename Inner::State;
  using Factor = typename Inner::Factor;
  using Landmarks = LandmarksT;
  using Window = typename Inner::Window;
  struct Options {
    LevenbergMarquardtOptions solver;
  };

  BareBackend(const Options&, const typename PropagationT::Options& propagation) : inner({}, propagation) {}
  Window& window() { return inner.window(); }
  const Window& window() const { return inner.window(); }
  const typename Inner::Factors& factors() const { return inner.factors(); }
  int start(TimeNs t_ns, const State& x) { return inner.start(t_ns, x); }
  int insert(TimeNs t_ns, const State& x, const Factor& factor) { return inner.insert(t_ns, x, factor); }
  void drop(Landmarks& landmarks, int slot) { inner.drop(landmarks, slot); }
  void optimize(const Sensors& rig, const SE3<S>& T_body_cam, Landmarks& landmarks, bool keyframe = true) {
    inner.optimize(rig, T_body_cam, landmarks, keyframe);
  }
  Retired<State, Landmarks> retired(int slot, const Landmarks& landmarks) const {
    return inner.retired(slot, landmarks);
  }
  void retire(const Sensors& rig, const SE3<S>& T_body_cam, Landmarks& landmarks, int slot, auto& map) {
    inner.retire(rig, T_body_cam, landmarks, slot, map);
  }
  bool covariance_of_newest(Mat<S, 6, 6>& covariance) const { return inner.covariance_of_newest(covariance); }
};

/// And what frames with IMU factors and a camera without depth add.
template <class PropagationT, class LandmarksT>
class BareImuBackend : public BareBackend<PropagationT, LandmarksT> {
  using Base = BareBackend<PropagationT, LandmarksT>;
  using Base::inner;

 public:
  using S = typename Base::S;
  using Base::Base;
  using Base::optimize;
  void optimize(const typename Base::Sensors& rig, const SE3<S>& T_body_cam, LandmarksT& landmarks,
                const LevenbergMarquardtOptions& solver) {
    inner.optimize(rig, T_body_cam, landmarks, solver);
  }
  void restart(auto&& state_of, const Mat<double, 6, InertialLayout::dim>& J_prior, const SE3<S>& T_body_cam,
               const TimeOffsetEstimate& time_offset) {
    inner.restart(state_of, J_prior, T_body_cam, time_offset);
  }
  bool covariance_of_keyframe(Mat<S, MovingLayout::dim, MovingLayout::dim>& covariance) const {
    return inner.covariance_of_newest(covariance);
  }
  void hold_scale(int i, int j) { inner.hold_scale(i, j); }
  void hold_distance(int i, int j, double distance, double sigma) { inner.hold_distance(i, j, distance, sigma); }
};

/// Follows points.
template <class Store, class Layout>
class BareFrontEnd : Pinned {
  using Inner = PointFlow<Store>;
  using Sensors = typename Store::Kind::Sensors;
  using S = typename Store::S;
  using Frames = FrameWindow<S, Layout, slots>;

 public:
  using Options = typename Inner::Options;
  static constexpr bool gives_correspondences = true, relates_two_views = !Sensors::has_depth;
  explicit BareFrontEnd(const Options& options) : inner_(options) {}

  void follow(const View<Sensors>& view, const Frames& frames, Store& store, const SE3<S>& T) {
    inner_.follow(view, frames, store, T);
  }
  void refine(const View<Sensors>& view, const Frames& frames, Store& store, const SE3<S>& T) {
    inner_.refine(view, frames, store, T);
  }
  void locate(const View<Sensors>& view, const Frames& frames, Store& store, const SE3<S>& T) {
    inner_.locate(view, frames, store, T);
  }
  void detect(const View<Sensors>& view, const Frames& frames, Store& store, int slot) {
    inner_.detect(view, frames, store, slot);
  }
  void for_each_correspondence(const View<Sensors>& view, const Frames& frames, const Store& store, auto&& take) const {
    inner_.for_each_correspondence(view, frames, store, take);
  }
  void for_each_pair(const View<Sensors>& view, const Store& store, int slot, auto&& visit) const {
    inner_.for_each_pair(view, store, slot, visit);
  }

 private:
  Inner inner_;
};
template <class Layout>
struct FollowPoints {
  template <class Entry, class Store>
  using Of = BareFrontEnd<Store, Layout>;
};

struct BareWindow {
  static constexpr int slots = ::slots;
  using FrontEnds = FollowPoints<VisualLayout>;
  template <Propagation P, class Landmarks>
  using Backend = BareBackend<P, Landmarks>;
};
struct BareImuWindow {
  static constexpr int slots = ::slots;
  using FrontEnds = FollowPoints<InertialLayout>;
  template <Propagation P, class Landmarks>
  using Backend = BareImuBackend<P, Landmarks>;
};

/// Counts what it is told.
struct CountKeyframes {
  struct Options {};
  template <class Parts>
  class Map : Pinned {
   public:
    Map(const typename Parts::Sensors&, const Options&) {}
    void on_keyframe(
        const AdoptedKeyframe<typename Parts::Window, typename Parts::Sensors, typename Parts::Landmarks>&) {
      ++keyframes;
    }
    void on_retired(const Retired<typename Parts::Window::Value, typename Parts::Landmarks>&) { ++retired; }
    void on_world_change(const WorldChange<typename Parts::S>&) { ++changes; }
    void work() { ++frames; }
    Sim3<typename Parts::S> S_map_world() const { return {}; }
    int keyframes = 0, retired = 0, changes = 0, frames = 0;
  };
};

/// Runs the task when it is waited for.
class WhenWaitedFor : Pinned {
 public:
  void start(void (*run)(void*), void* context) { run_ = run, context_ = context; }
  void wait() {
    if (auto* run = std::exchange(run_, nullptr)) run(context_);
  }
  ~WhenWaitedFor() { wait(); }

 private:
  void (*run_)(void*) = nullptr;
  void* context_ = nullptr;
};

}  // namespace

template <>
struct plumbline::PropagationOf<RgbdRig> {
  using Type = BareRollingPropagation<RgbdRig, ConstantVelocity<RgbdRig>>;
};
template <>
struct plumbline::InitializerOf<RgbdRig> {
  using Type = NoInitializer;
};
template <>
struct plumbline::PropagationOf<MonoImuRig> {
  using Type = BareImuPropagation<MonoImuRig, Inertial<MonoImuRig>>;
};
template <>
struct plumbline::InitializerOf<MonoImuRig> {
  using Type = BareInitializer;
};

namespace {

using Vo = Estimator<RgbdRig, Features<Points<150>>, BareWindow, NoClock, CountKeyframes, WhenWaitedFor>;
using Vio = Estimator<MonoImuRig, Features<Points<150>>, BareImuWindow, NoClock, CountKeyframes, WhenWaitedFor>;

template <class Rig>
Rig rig_of(const test::SimulatedRgbd& simulated) {
  Rig rig{};
  rig.vision.camera = simulated.camera;
  rig.vision.width = test::SimulatedRgbd::width;
  rig.vision.height = test::SimulatedRgbd::height;
  return rig;
}

}  // namespace

TEST_CASE("archetypes: frames of an RGB-D camera are tracked by policies that have nothing but what is listed") {
  const test::SimulatedRgbd room(30);
  const auto vo = std::make_unique<Vo>(rig_of<RgbdRig>(room));
  for (std::size_t k = 0; k < room.frames.size(); ++k) {
    const auto& frame = room.frames[k];
    const auto estimate = vo->add_frame({room.t_ns[k], frame.gray.view(), frame.depth.view()});
    REQUIRE(estimate);
    CHECK(estimate->health.state == HealthState::tracking);
    const SE3<double> T_first_now = room.T_world_cam[0].inverse() * room.T_world_cam[k];
    CHECK((estimate->T_world_body.p() - T_first_now.p()).norm() < 0.02);
  }
  CHECK(vo->map().frames == int(room.frames.size()));
  CHECK(vo->map().keyframes >= 1);
  vo->request_reset();
  REQUIRE(vo->add_frame({room.t_ns.back() + 1, room.frames.back().gray.view(), room.frames.back().depth.view()}));
  CHECK(vo->map().changes == 2);
}

TEST_CASE("archetypes: two views and IMU samples are taken by policies that have nothing but what is listed") {
  const test::SimulatedRgbd room(80);
  MonoImuRig rig = rig_of<MonoImuRig>(room);
  rig.imu.T_body_cam = testing::simulated_T_body_camera();
  rig.imu.noise = testing::ImuQuality{}.noise;
  const auto vio = std::make_unique<Vio>(rig);
  const auto trajectory = *testing::Trajectory::for_scene("room");
  testing::SimulatedImu imu({}, 1);
  auto measured = imu.next(trajectory);
  bool was_visual_only = false;
  for (std::size_t k = 0; k < room.frames.size(); ++k) {
    for (; measured.sample(0).t_ns <= room.t_ns[k]; measured = imu.next(trajectory))
      (void)vio->add_imu(measured.sample(0));
    REQUIRE(vio->add_frame({room.t_ns[k], room.frames[k].gray.view()}));
    was_visual_only = was_visual_only || vio->tracking_state() == TrackingState::visual_only;
  }
  CHECK((was_visual_only || vio->tracking_state() == TrackingState::nominal));
  CHECK(vio->map().keyframes >= 1);
}
