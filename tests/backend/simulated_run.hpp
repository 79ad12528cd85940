#pragma once
// Visual-inertial runs at the level of features, with exact truth: the backend is driven as an estimator drives it, the
// images are replaced by what a camera on the way through a cloud of points and lines would measure.
//
// Every noise is that of the backend's options: pixels, depths, IMU, initial biases, position and heading of the
// first keyframe, extrinsics and time offset of the camera. What comes out wrong is then the backend's own.
//                                                                                docs/math/inertial_window.md

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <vector>

#include "feature/seen_lines.hpp"
#include "plumbline/backend/backend.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/factor/absolute_position.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/frontend/flow.hpp"
#include "plumbline/frontend/front_ends.hpp"
#include "plumbline/frontend/line_location.hpp"
#include "plumbline/initialization/depth.hpp"
#include "plumbline/initialization/inertial.hpp"
#include "plumbline/map/no_map.hpp"
#include "plumbline/propagation/inertial.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/testing/gaussian.hpp"
#include "plumbline/testing/rig.hpp"
#include "plumbline/testing/simulated_imu.hpp"
#include "plumbline/testing/simulated_points.hpp"
#include "plumbline/testing/trajectory.hpp"
#include "residual/points.hpp"

namespace plumbline::test {

using MonoImu = Rig<Mono<Pinhole<double>, 64 * 64>, Imu>;  // images are never used
using RgbdImu = Rig<Rgbd<Pinhole<double>, 64 * 64>, Imu>;

struct RunOptions {
  double noise = 1;              ///< of points, IMU and first keyframe, as simulated and as claimed; biases stay
  double sigma_first = 1e-3;     ///< of place [m] and heading [rad] of the first keyframe
  int start_keyframes = 6;       ///< with which the inertial window begins
  double start_tilt = 0.005;     ///< of the world they are in [rad]
  double start_scale_sigma = 0;  ///< of their distances, relative; known to the window
  int frames_per_keyframe = 5;
  int points = 1200, lines = 300;                         ///< in the world
  std::size_t points_in_sight = 50, lines_in_sight = 15;  ///< are made up to by keyframes
  /// Of a position measured from outside in every n-th keyframe, as simulated and as claimed [m]; 0: there is none.
  double sigma_position = 0;
  int keyframes_per_position = 4;
};

/// Errors of one frame.
struct FrameError {
  double position = 0, rotation = 0;            ///< [m], [rad]
  double nees_position = 0, nees_rotation = 0;  ///< chi-square of three degrees of freedom each
  double nees_extrinsics = 0;                   ///< six
};

/// Segments in the world.
struct SimulatedLines {
  std::vector<Vec<double, 3>> p_world, q_world;

  void scatter(int count, const Vec<double, 3>& half_size, std::uint64_t seed) {
    Random random(seed);
    for (int i = 0; i < count; ++i) {
      const Vec<double, 3> d = random_vector(random, 1).normalized();
      p_world.push_back(random_vector(random, 1).cwiseProduct(half_size));
      q_world.push_back(p_world.back() + (0.5 + random.uniform()) * d);
    }
  }
};

/// BackendPolicy as an estimator names it; its front ends are not used.
template <class BackendPolicy, class Sensors, class... Kinds>
class BackendRun {
 public:
  static constexpr int K = BackendPolicy::slots;
  using S = typename Sensors::Scalar;
  using Propagation = Inertial<Sensors>;
  using FrontEnds = plumbline::FrontEnds<Flow, Sensors, K, Features<Kinds...>>;
  using Landmarks = typename FrontEnds::Landmarks;
  using Backend = typename BackendPolicy::template Backend<Propagation, Landmarks>;

  explicit BackendRun(std::uint64_t seed, const RunOptions& options = {})
      : options_(options),
        trajectory_(*testing::Trajectory::for_scene("room", seed)),
        imu_(quality(options.noise), seed),
        noise_(testing::stream_seed(seed, 20)),
        position_noise_(testing::stream_seed(seed, 26)) {
    window_options_.sigma_first_position = window_options_.sigma_first_rotation = options.noise * options.sigma_first;
    window_options_.extrinsics.rotation_sigma *= options.noise;
    window_options_.extrinsics.position_sigma *= options.noise;
    window_options_.time_offset.sigma_s *= options.noise;
    time_offset_s_ = window_options_.time_offset.sigma_s * testing::Gaussian(testing::stream_seed(seed, 24))();
    backend_ = std::make_unique<Backend>(window_options_, typename Propagation::Options{});
    points_.sigma_px *= options.noise;
    points_.sigma_inverse_depth *= options.noise;
    points_.scatter(options.points, {4.5, 4.5, 3.5}, testing::stream_seed(seed, 21));
    lines_.scatter(options.lines, {4, 4, 3}, testing::stream_seed(seed, 22));
    rig_.vision.camera = points_.camera;
    rig_.imu.T_body_cam = calibrated(testing::stream_seed(seed, 23));
    while (measured_.t < first_s) measured_ = imu_.next(trajectory_);
    start(seed);
  }

  /// The next frame, and its errors.
  FrameError step() {
    advance();
    const NavState<S> x = since_frame_.increment().predict(state_, backend_->factors().gravity());
    if (temporary_slot_ >= 0) backend_->drop(*landmarks_, temporary_slot_);
    temporary_slot_ = -1;
    const bool keyframe = ++frames_ % options_.frames_per_keyframe == 0;
    const int slot = backend_->insert(t_ns_, x, factor());
    observe(slot, keyframe);
    if (frames_ % (options_.keyframes_per_position * options_.frames_per_keyframe) == 0) measure_position(slot);
    const SE3<double> before = first_estimate_of_oldest();
    backend_->optimize(rig_, T_body_cam(), *landmarks_, keyframe);
    T_moved_ = first_estimate_of_oldest() * before.inverse() * T_moved_;
    state_ = backend_->window()[slot].state.value();
    locate();
    const FrameError out = error();
    if (keyframe) {
      adopt_keyframe(slot);
      if (backend_->window().full()) {
        NoMap::Discard<S> map;
        backend_->retire(rig_, T_body_cam(), *landmarks_, backend_->window().oldest(), map);
        ++retirements_;
      }
    } else {
      temporary_slot_ = slot;
    }
    return out;
  }

  /// Frames without images, then a keyframe of new landmarks at the IMU-propagated pose, as in estimator/recovery.hpp.
  void black_out(int frames) {
    for (int k = 0; k < frames; ++k) {
      advance();
      state_ = since_frame_.increment().predict(state_, backend_->factors().gravity());
    }
    if (temporary_slot_ >= 0) backend_->drop(*landmarks_, temporary_slot_);
    temporary_slot_ = -1;
    landmarks_->for_each([](auto& store) { store.clear(); });
    const int slot = backend_->insert(t_ns_, state_, factor());
    observe(slot, true);
    adopt_keyframe(slot);
    if (!backend_->window().full()) return;
    NoMap::Discard<S> map;
    backend_->retire(rig_, T_body_cam(), *landmarks_, backend_->window().oldest(), map);
  }

  FrameError error() const {
    const Vec<double, 6> d = minus(T_world_body(), state_.T_world_body.template cast<double>());
    Mat<S, 6, 6> C = Mat<S, 6, 6>::Identity();
    const bool known = backend_->covariance_of_newest(C);
    const auto nees = [&](int i) {
      const Vec<double, 3> e = d.segment<3>(i);
      const Mat<double, 3, 3> block = C.template block<3, 3>(i, i).template cast<double>();
      return known ? e.dot(block.inverse() * e) : std::nan("");
    };
    return {d.tail<3>().norm(), d.head<3>().norm(), nees(3), nees(0), nees_extrinsics()};
  }

  double nees_extrinsics() const {
    const Vec<double, 6> d = minus(testing::simulated_T_body_camera(), T_body_cam().template cast<double>());
    Mat<double, 6, 6> C;
    return backend_->covariance_of_extrinsics(C) ? d.dot(C.inverse() * d) : std::nan("");
  }

  /// Of the time offset of the camera, one degree of freedom.
  double nees_time_offset() const {
    double sigma_s = 0;
    const double e = backend_->window().time_offset_s(0) - time_offset_s_;
    return backend_->sigma_of_time_offset(sigma_s) ? e * e / (sigma_s * sigma_s) : std::nan("");
  }

  /// Of the speed, which is what a scale that is not known makes wrong, one degree of freedom.
  double nees_speed() const {
    constexpr int dim = MovingLayout::dim, at = InertialLayout::offset<state::Velocity>;
    Mat<S, dim, dim> C;
    if (!backend_->covariance_of_newest(C)) return std::nan("");
    const Vec<double, 3> v = trajectory_.at(measured_.t + time_offset_s_).v_world_body;
    const Vec<double, 3> along = state_.v_world_body.template cast<double>().normalized();
    const double e = along.dot(state_.v_world_body.template cast<double>()) - v.norm();
    return e * e / along.dot(C.template block<3, 3>(at, at).template cast<double>() * along);
  }

  /// Information on the heading and position of the whole, in units of what the first keyframe's prior knew of it: that
  /// of the newest pose along its motions N when the whole turns about the vertical through its start and moves,
  ///   eigenvalues of sigma^2 N^T C^-1 N,  ascending.
  /// Were C that of the prior alone, all four were one; all that is unknown between start and now makes them less, and
  /// no measurement can make them more.
  Vec<double, 4> information_on_the_whole() const {
    const auto& window = backend_->window();
    const SE3<double> T = window[window.newest()].state.first_estimate().T_world_body.template cast<double>();
    const Mat<double, 3, 3> R_body_world = T.R().transpose();
    const Vec<double, 3> up = Vec<double, 3>::UnitZ();
    Mat<double, 6, 4> N = Mat<double, 6, 4>::Zero();
    N.col(0) << R_body_world * up, R_body_world * up.cross(Vec<double, 3>(T.p() - T_moved_ * T_start_.p()));
    N.bottomRightCorner<3, 3>() = R_body_world;
    Mat<S, 6, 6> C = Mat<S, 6, 6>::Identity();
    if (!backend_->covariance_of_newest(C)) return Vec<double, 4>::Constant(std::nan(""));
    const double sigma = window_options_.sigma_first_position;
    const Mat<double, 4, 4> information = sigma * sigma * N.transpose() * C.template cast<double>().inverse() * N;
    return Eigen::SelfAdjointEigenSolver<Mat<double, 4, 4>>(information, Eigen::EigenvaluesOnly).eigenvalues();
  }

  int retirements() const { return retirements_; }
  /// Positions measured from outside that the backend took.
  int positions() const { return positions_; }
  const Backend& backend() const { return *backend_; }
  const NavState<S>& state() const { return state_; }
  const testing::SimulatedImu::Measurement& truth() const { return measured_; }
  Landmarks& landmarks() { return *landmarks_; }

 private:
  using PointSeen = PointObservation<S, Sensors::has_depth, Sensors::rolls>;
  using SegmentSeen = SegmentObservation<S, Sensors::has_depth, Sensors::rolls>;

  static constexpr double first_s = 2.5;  ///< the path has left its stationarity
  static constexpr int samples_per_frame = 10;

  /// A prior refers to it: it moves with the whole window alone, (7) of window.md.
  SE3<double> first_estimate_of_oldest() const {
    const auto& window = backend_->window();
    return window[window.oldest()].state.first_estimate().T_world_body.template cast<double>();
  }
  static testing::ImuQuality quality(double noise) {
    testing::ImuQuality out;
    out.noise.gyro_density *= noise;
    out.noise.accel_density *= noise;
    out.noise.gyro_walk *= noise;
    out.noise.accel_walk *= noise;
    const InertialInitializerOptions claimed;
    out.gyro_bias_sigma = claimed.gyro_bias_sigma;
    out.accel_bias_sigma = claimed.accel_bias_sigma;
    return out;
  }

  /// When the image was taken: its time stamp lacks the time offset, without which the IMU samples are cut.
  SE3<double> T_world_body() const { return trajectory_.at(measured_.t + time_offset_s_).T_world_body; }
  SE3<double> T_world_cam() const { return T_world_body() * testing::simulated_T_body_camera(); }
  ImuFactor<S> factor() const {
    return {keyframe_slot_, since_keyframe_, quality(options_.noise).noise, false, false, keyframe_cut_, cut()};
  }
  SampleBoundary<S> cut() const { return {0, measured_.gyro.template cast<S>()}; }
  /// The extrinsics as a calibration has them.
  SE3<double> calibrated(std::uint64_t seed) const {
    testing::Gaussian noise(seed);
    const ExtrinsicsOptions& sigma = window_options_.extrinsics;
    Vec<double, 6> off;
    off << sigma.rotation_sigma * noise.vector<3>(), sigma.position_sigma * noise.vector<3>();
    return plus(testing::simulated_T_body_camera(), off);
  }
  /// As the backend estimates it, or as calibrated.
  SE3<S> T_body_cam() const { return backend_->window().T_body_cam(rig_.T_body_cam()); }

  /// On to the next frame's time.
  void advance() {
    const ImuNoise noise = quality(options_.noise).noise;
    since_frame_ = Preintegration<S>(noise, state_.bias_gyro, state_.bias_accel);
    for (int i = 0; i < samples_per_frame; ++i) {
      const testing::SimulatedImu::Measurement next = imu_.next(trajectory_);
      const ImuInterval<double> interval{next.t - measured_.t, measured_.gyro, next.gyro, measured_.accel, next.accel};
      since_frame_.add(interval.template cast<S>());
      measured_ = next;
    }
    since_keyframe_.append(since_frame_.intervals());
    t_ns_ = TimeNs(measured_.t * 1e9);
  }

  /// Position of an antenna, by backends that take it.
  void measure_position(int slot) {
    if constexpr (TakesFactor<Backend, AbsolutePosition<S>>) {
      if (!(options_.sigma_position > 0)) return;
      const Vec<double, 3> p_body_antenna{0.2, -0.1, 0.4};
      const Vec<double, 3> p = T_world_body() * p_body_antenna + options_.sigma_position * position_noise_.vector<3>();
      const AbsolutePosition<S> factor{p.cast<S>(), Mat<S, 3, 3>::Identity() / S(options_.sigma_position),
                                       p_body_antenna.cast<S>()};
      positions_ += backend_->add_factor(slot, factor);
    }
  }

  void adopt_keyframe(int slot) {
    keyframe_slot_ = slot;
    keyframe_cut_ = cut();
    since_keyframe_ = {};
  }

  /// The first keyframes as vision alone would have put them, and the inertial window over them.
  void start(std::uint64_t seed) {
    const SE3<double> T_first = T_world_body();
    const auto& w = window_options_;
    // In the world: tilt, which is measured, and heading, which is not.
    const Vec<double, 3> turn{options_.start_tilt * noise_(), options_.start_tilt * noise_(),
                              w.sigma_first_rotation * noise_()};
    T_start_ = SE3<double>(SO3<double>::exp(turn) * T_first.rotation(),
                           T_first.p() + w.sigma_first_position * noise_.vector<3>());
    const double scale = std::exp(options_.start_scale_sigma * testing::Gaussian(testing::stream_seed(seed, 25))());
    std::vector<NavState<S>> states(static_cast<std::size_t>(K));
    for (int k = 0; k < options_.start_keyframes; ++k) {
      SE3<double> T = T_start_;
      if (k > 0) {
        for (int i = 0; i < options_.frames_per_keyframe; ++i) advance();
        Vec<double, 6> off;
        off << 0.002 * noise_.vector<3>(), 0.005 * noise_.vector<3>();
        const SE3<double> T_first_body = T_first.inverse() * T_world_body();
        T = plus(T_start_ * SE3<double>(T_first_body.rotation(), scale * T_first_body.p()), off);
      }
      state_.T_world_body = T.template cast<S>();
      const int slot = k == 0 ? backend_->start(t_ns_, state_) : backend_->insert(t_ns_, state_, factor());
      states[std::size_t(slot)] = state_;
      observe(slot, true);
      locate();
      adopt_keyframe(slot);
    }
    const auto& window = backend_->window();
    begin([&](int slot) { return states[std::size_t(slot)]; });
    const int oldest = window.oldest();
    const double length = (window.T_world_body(keyframe_slot_).p() - window.T_world_body(oldest).p()).norm();
    solve(length);
    if (options_.start_scale_sigma > 0) {
      begin([&](int slot) { return window[slot].state.value(); });
      solve(length);
    }
    state_ = backend_->window()[keyframe_slot_].state.value();
    since_keyframe_ = {};
  }

  /// As estimator/initialization.hpp does.
  void begin(auto&& state_of) {
    const InertialInitializer<S, DepthInitializer<S>> start({});
    backend_->restart(state_of, start.prior_on_biases(), rig_.T_body_cam(), {.is_known = false});
  }
  void solve(double length) {
    const double sigma = options_.start_scale_sigma * length;
    if (sigma > 0) backend_->hold_distance(backend_->window().oldest(), keyframe_slot_, length, sigma);
    LevenbergMarquardtOptions solver = window_options_.solver;
    solver.max_iterations *= 4;
    backend_->optimize(rig_, T_body_cam(), *landmarks_, solver);
  }

  // ----------------------------------------------------------------------------------------------- observations

  void observe(int slot, bool keyframe) {
    landmarks_->for_each([&](auto& store) { observe_kind(store, slot, keyframe); });
  }

  /// Landmarks that have no depth, by this frame's view of them.
  void locate() {
    const View<Sensors> view{
        t_ns_, S(0), rig_, *pyramid_, *pyramid_, {}, {}, T_body_cam(), {rig_.vision.camera, points_.height, S(0)}};
    front_ends_->locate(view, backend_->window(), *landmarks_, state_.T_world_body);
  }

  /// All landmarks of the store, then new ones in a keyframe. Ids are indices into the world.
  template <class Store>
  void observe_kind(Store& store, int slot, bool keyframe) {
    constexpr bool is_points = std::is_same_v<typename Store::Kind::Observation, PointSeen>;
    const std::size_t in_world = is_points ? points_.p_world.size() : lines_.p_world.size();
    std::vector<bool> known(in_world);
    std::size_t in_sight = 0;
    for (auto& landmark : store.landmarks()) {
      known[landmark.id] = true;
      landmark.current = measure(landmark.current, landmark.id, true);
      in_sight += landmark.current.valid;
      landmark.misses = landmark.current.valid ? 0 : landmark.misses + 1;
    }
    store.record(slot);
    if (!keyframe) return;
    const std::size_t wanted = is_points ? options_.points_in_sight : options_.lines_in_sight;
    for (std::size_t id = 0; id < in_world && in_sight < wanted && !store.landmarks().full(); ++id) {
      if (known[id]) continue;
      typename Store::Landmark landmark;
      landmark.current = measure(landmark.current, std::uint32_t(id), false);
      if (!landmark.current.valid) continue;
      landmark.id = std::uint32_t(id);
      landmark.anchor = slot;
      landmark.observations[std::size_t(slot)] = landmark.current;
      if constexpr (is_points) {
        begin_point(landmark);
      } else {
        begin_line(landmark);
      }
      store.landmarks().push_back(landmark);
      ++in_sight;
    }
  }

  /// The first argument is of its kind. A point's pixel in its anchor has no noise, it defines the point.
  PointSeen measure(const PointSeen&, std::uint32_t id, bool noisy) {
    const testing::SeenPoint seen = points_.see(T_world_cam(), id);
    PointSeen out;
    out.valid = seen.valid;
    if (!out.valid) return out;
    Vec<double, 2> uv = seen.uv;
    if (noisy) uv += points_.sigma_px * noise_.vector<2>();
    out.pixel = out.uv = uv.cast<float>();
    out.L = Mat<float, 2, 2>::Identity() / float(points_.sigma_px);
    if constexpr (Sensors::has_depth) {
      out.depth.set(
          {true, S(1 / seen.p_cam.z() + points_.sigma_inverse_depth * noise_()), S(points_.sigma_inverse_depth)});
    }
    return out;
  }
  void begin_point(auto& landmark) const {
    auto& point = landmark.geometry;
    point.bearing = rig_.vision.camera.unproject(landmark.current.uv.template cast<S>()).bearing;
    const InverseDepth<S>& depth = landmark.current.depth.get();
    if (!depth.valid) return;
    landmark.located = true;
    point.inverse_range = depth.value * point.bearing.z();
    point.sigma_inverse_range = depth.sigma * point.bearing.z();
  }

  SegmentSeen measure(const SegmentSeen&, std::uint32_t id, bool) {
    const SE3<double> T_cam_world = T_world_cam().inverse();
    const Vec<double, 3> p = T_cam_world * lines_.p_world[id], q = T_cam_world * lines_.q_world[id];
    if (!in_image(p) || !in_image(q)) return {};
    const auto& camera = points_.camera;
    if (!((camera.project(p).uv - camera.project(q).uv).norm() > 60)) return {};
    return observe_segment<SegmentSeen>(camera, p, q, 1, noise_);
  }
  void begin_line(auto& landmark) const {
    const SegmentSeen& seen = landmark.current;
    if (!seen.has_depth()) return;
    const LineInverseDepth<S>& depth = seen.depth.get().measured;
    landmark.geometry.line = line_from_depth(depth.m_start, depth.m_end, depth.inverse_depth_measured);
    landmark.geometry.set_extent(SE3<S>(), seen.pixels.measured.bearing_start, seen.pixels.measured.bearing_end);
    landmark.located = true;
  }

  bool in_image(const Vec<double, 3>& p) const {
    if (!(p.z() > points_.z_min && p.z() < points_.z_max)) return false;
    const Vec<double, 2> uv = points_.camera.project(p).uv;
    return uv.x() >= 0 && uv.y() >= 0 && uv.x() <= points_.width - 1 && uv.y() <= points_.height - 1;
  }

  RunOptions options_;
  typename Backend::Options window_options_;
  testing::Trajectory trajectory_;
  testing::SimulatedImu imu_;
  testing::Gaussian noise_, position_noise_;
  testing::SimulatedPoints points_;
  SimulatedLines lines_;
  Sensors rig_{};
  std::unique_ptr<Landmarks> landmarks_ = std::make_unique<Landmarks>(FrontEnds::make_landmarks({}));
  std::unique_ptr<FrontEnds> front_ends_ = std::make_unique<FrontEnds>(typename FrontEnds::Options{});
  std::unique_ptr<Backend> backend_;
  std::unique_ptr<RigPyramid<Sensors>> pyramid_ = std::make_unique<RigPyramid<Sensors>>();

  testing::SimulatedImu::Measurement measured_{-1, {}, {}, {}, {}, {}};  ///< the latest, at the time of the frame
  double time_offset_s_ = 0;                                             ///< of the camera, whose calibration has none
  SampleBoundary<S> keyframe_cut_;
  TimeNs t_ns_ = 0;
  SE3<double> T_start_;  ///< initial estimate of the first keyframe
  SE3<double> T_moved_;  ///< by which the window was moved as a whole since
  NavState<S> state_;    ///< of the latest frame
  Preintegration<S> since_frame_;
  ImuIntervals<S> since_keyframe_;
  int keyframe_slot_ = 0, temporary_slot_ = -1, frames_ = 0, retirements_ = 0, positions_ = 0;
};

template <class Sensors, int K, class... Kinds>
using SimulatedRun = BackendRun<SlidingWindow<K>, Sensors, Kinds...>;

}  // namespace plumbline::test
