// One solve of a window with an IMU: 10 keyframes of 15 parameters, 9 increments between them, 150 points and 40 lines,
// seen with their depth by every keyframe, 1 % of the pixels wrong. Ceres solves the same problem as in window_solve.
#include "ceres_window.hpp"

#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/initialization/depth.hpp"
#include "plumbline/initialization/inertial.hpp"
#include "plumbline/propagation/inertial.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/testing/simulated_points.hpp"

namespace plumbline {
namespace {

using namespace bench;

constexpr int keyframes = 10, points = 150, lines = 40;

/// A body that turns steadily and swings.
struct Motion {
  static constexpr double interval_s = 0.25;  ///< between keyframes
  Vec<double, 3> w{0.08, -0.12, 0.04}, swing{0.25, 0.15, 0.2}, rate{1.1, 1.7, 1.4};

  SO3<double> rotation(double t) const { return SO3<double>::exp(t * w); }
  NavState<double> at(double t) const {
    const Vec<double, 3> phase = t * rate, p = swing.array() * phase.array().sin();
    const Vec<double, 3> v = swing.array() * rate.array() * phase.array().cos();
    return {SE3<double>(rotation(t), p - 3.5 * Vec<double, 3>::UnitZ()), v};
  }
  /// Exact measurement of an accelerometer.
  Vec<double, 3> specific_force(double t) const {
    const Vec<double, 3> a = -swing.array() * rate.array().square() * (t * rate).array().sin();
    return rotation(t).inverse() * Vec<double, 3>(a - gravity_in_world<double>());
  }
};

template <class S>
struct Window {
  using Sensors = Rig<Rgbd<Pinhole<S>, 64 * 64>, Imu>;
  using Landmarks = typename Features<Points<points>, Lines<lines>>::template Landmarks<Sensors, keyframes>;
  using Backend = WindowBackend<Inertial<Sensors>, Landmarks, keyframes>;
  using LineStore = std::remove_reference_t<decltype(std::declval<Landmarks&>().template get<1>())>;

  Sensors rig;
  Landmarks landmarks{StoreOptions{}, StoreOptions{}};
  Backend backend{with_known_extrinsics(), {}};

  /// The first keyframe is exact, it defines the world; the others start 2 cm, 1 degree and 5 cm/s off.
  Window() {
    testing::SimulatedPoints scene, ends;
    scene.outlier_share = 0.01;
    rig.vision.camera = {S(scene.camera.fx), S(scene.camera.fy), S(scene.camera.cx), S(scene.camera.cy), {}};
    rig.vision.width = rig.vision.height = 64;
    scene.scatter(2 * points, {1.0, 0.8, 1.2}, 1);
    ends.scatter(lines, {0.6, 0.4, 1.0}, 3);
    for (int i = 0; i < lines; ++i) {  // 60 cm long, in all directions
      const double angle = i;
      ends.p_world.push_back(ends.p_world[std::size_t(i)] +
                             Vec<double, 3>(0.5 * std::cos(angle), 0.5 * std::sin(angle), 0.3));
    }
    testing::Gaussian noise(2);
    const Motion motion;
    std::vector<NavState<S>> starts;
    for (int k = 0; k < keyframes; ++k) {
      const NavState<double> x = motion.at(k * Motion::interval_s);
      Vec<double, 15> error = Vec<double, 15>::Zero();
      if (k > 0) error.head<9>() << 0.017 * noise.vector<3>(), 0.02 * noise.vector<3>(), 0.05 * noise.vector<3>();
      starts.push_back(plus(x, error).template cast<S>());
      int slot = k == 0 ? backend.start(0, {starts[0].T_world_body}) : 0;
      if (k > 0) slot = backend.insert(k, starts.back(), {k - 1, samples(motion, k, noise)});
      scene.observe(landmarks.template get<0>(), x.T_world_body, slot, noise);
      observe(landmarks.template get<1>(), ends, x.T_world_body, slot, noise);
    }
    const InertialInitializer<S, DepthInitializer<S>> start({});
    backend.restart([&](int slot) { return starts[std::size_t(slot)]; }, start.prior_on_biases(), rig.T_body_cam());
    for (int k = 0; k < keyframes; ++k) {  // with the velocities above, not those derived from the positions
      using Velocity = Estimated<state::Velocity, S>;
      backend.window().state(k).template get<state::Velocity>() = Velocity(starts[std::size_t(k)].v_world_body);
    }
    backend.window().state(0).fix_first_estimates();
  }

  LevenbergMarquardtSummary solve() { return backend.optimize(rig, rig.T_body_cam(), landmarks); }
  NavState<S> state(int slot) const { return backend.window()[slot].state.value(); }
  const auto& point_landmarks() const { return landmarks.template get<0>().landmarks(); }
  const auto& line_landmarks() const { return landmarks.template get<1>().landmarks(); }

 private:
  /// Ceres has it as given.
  static WindowOptions with_known_extrinsics() {
    WindowOptions out;
    out.extrinsics.rotation_sigma = out.extrinsics.position_sigma = 0;
    return out;
  }

  /// The IMU samples before keyframe k, at 200 Hz.
  static ImuIntervals<S> samples(const Motion& motion, int k, testing::Gaussian& noise) {
    const ImuNoise spread;
    ImuIntervals<S> out;
    const double root = std::sqrt(spread.rate_hz), dt = 1 / spread.rate_hz;
    const auto gyro = [&] { return Vec<double, 3>(motion.w + spread.gyro_density * root * noise.vector<3>()); };
    const auto accel = [&](double t) {
      return Vec<double, 3>(motion.specific_force(t) + spread.accel_density * root * noise.vector<3>());
    };
    double t = (k - 1) * Motion::interval_s;
    Vec<double, 3> last_gyro = gyro(), last_accel = accel(t);
    for (int n = 0; n < int(Motion::interval_s * spread.rate_hz); ++n, t += dt) {
      const ImuInterval<double> interval{dt, last_gyro, gyro(), last_accel, accel(t + dt)};
      out.add(interval.cast<S>());
      last_gyro = interval.gyro_end;
      last_accel = interval.accel_end;
    }
    return out;
  }

  /// Line i is that through the points i and lines + i; its start is a little off.
  static void observe(LineStore& store, const testing::SimulatedPoints& ends, const SE3<double>& T_world_cam, int slot,
                      testing::Gaussian& noise) {
    const double sigma_px = 0.5, sigma_inverse_depth = 5e-3;
    for (std::size_t i = 0; i < std::size_t(lines); ++i) {
      const testing::SeenPoint a = ends.see(T_world_cam, i), b = ends.see(T_world_cam, std::size_t(lines) + i);
      if (slot == 0) {
        typename LineStore::Landmark landmark;
        landmark.id = std::uint32_t(i);
        landmark.located = true;
        const Line3<double> line = Line3<double>::through(a.p_cam, b.p_cam);
        landmark.geometry.line = line.plus(0.01 * noise.vector<4>()).template cast<S>();
        store.landmarks().push_back(landmark);
      }
      const auto seen = observe_line(ends.camera, Vec<double, 2>(a.uv + sigma_px * noise.vector<2>()),
                                     Vec<double, 2>(b.uv + sigma_px * noise.vector<2>()));
      if (!seen.valid) continue;
      const LineReprojection<double>& pixels = seen.reprojection;
      auto& out = store.landmarks()[i].observations[std::size_t(slot)];
      const Mat<S, 2, 2> I = Mat<S, 2, 2>::Identity();
      out.pixels = {{pixels.bearing_start.template cast<S>(), pixels.bearing_end.template cast<S>(),
                     pixels.px_per_rad.template cast<S>()},
                    S(sigma_px * sigma_px) * I};
      out.valid = out.pixels.valid;
      const Vec<double, 2> inverse_depth(1 / a.p_cam.z(), 1 / b.p_cam.z());
      out.set_depth((inverse_depth + sigma_inverse_depth * noise.vector<2>()).cast<S>(),
                    S(sigma_inverse_depth * sigma_inverse_depth) * I);
    }
  }
};

#ifdef PLUMBLINE_CERES

/// A line as its six Pluecker coordinates, moving by `plus`; derivatives as with PoseManifold.
class LineManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 6; }
  int TangentSize() const override { return 4; }
  bool Plus(const double* x, const double* d, double* out) const override {
    write(read(x).plus(Vec<double, 4>(Eigen::Map<const Vec<double, 4>>(d))), out);
    return true;
  }
  bool PlusJacobian(const double*, double* J) const override {
    Eigen::Map<Eigen::Matrix<double, 6, 4, Eigen::RowMajor>> out(J);
    out.setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* d) const override {
    Eigen::Map<Vec<double, 4>> out(d);
    out = minus(read(y), read(x));
    return true;
  }
  bool MinusJacobian(const double*, double* J) const override {
    Eigen::Map<Eigen::Matrix<double, 4, 6, Eigen::RowMajor>> out(J);
    out.setIdentity();
    return true;
  }
  static Line3<double> read(const double* x) {
    return Line3<double>({Eigen::Map<const Vec<double, 3>>(x), Eigen::Map<const Vec<double, 3>>(x + 3)});
  }
  static void write(const Line3<double>& line, double* x) {
    Eigen::Map<Vec<double, 6>> out(x);
    out << line.plucker().n, line.plucker().v;
  }
};

template <int Rows>
void write_motion_jacobian(const Mat<double, Rows, 9>& J, double* out) {
  if (!out) return;
  Eigen::Map<Eigen::Matrix<double, Rows, 9, Eigen::RowMajor>> to(out);
  to = J;
}

void write_line_jacobian(const Mat<double, 2, 4>& J, double* out) {
  if (out) Eigen::Map<Eigen::Matrix<double, 2, 6, Eigen::RowMajor>>(out) << J, Mat<double, 2, 2>::Zero();
}

/// A line seen, or its depth measured, in another keyframe than its anchor.
template <class Measurement>
struct LineCost final : ceres::SizedCostFunction<2, 7, 7, 6> {
  AnchoredLine<Measurement> residual;
  Mat<double, 2, 2> L;
  LineCost(const Measurement& measurement, const Mat<double, 2, 2>& whitening) : residual{measurement}, L(whitening) {}
  bool Evaluate(const double* const* x, double* r, double** J) const override {
    const RelativeView<double> view(PoseManifold::read(x[0]), PoseManifold::read(x[1]), SE3<double>());
    const Line3<double> line = LineManifold::read(x[2]);
    Eigen::Map<Vec<double, 2>> out(r);
    if (!J) {
      out = L * residual.measurement.residual(line_in_target(view, line.plucker()));
      return true;
    }
    const auto lin = residual.linearize(view, line);
    if (!lin.valid) return false;
    out = L * lin.r;
    write_pose_jacobian<2>(L * lin.J_r_anchor, J[0]);
    write_pose_jacobian<2>(L * lin.J_r_target, J[1]);
    write_line_jacobian(L * lin.J_r_lambda, J[2]);
    return true;
  }
};

/// The same in the anchor.
template <class Measurement>
struct AnchorLineCost final : ceres::SizedCostFunction<2, 6> {
  AnchoredLine<Measurement> residual;
  Mat<double, 2, 2> L;
  AnchorLineCost(const Measurement& measurement, const Mat<double, 2, 2>& whitening)
      : residual{measurement}, L(whitening) {}
  bool Evaluate(const double* const* x, double* r, double** J) const override {
    const Line3<double> line = LineManifold::read(x[0]);
    Eigen::Map<Vec<double, 2>> out(r);
    if (!J) {
      out = L * residual.measurement.residual(line.plucker());
      return true;
    }
    const auto lin = residual.linearize_in_anchor(line);
    if (!lin.valid) return false;
    out = L * lin.r;
    write_line_jacobian(L * lin.J_r_line, J[0]);
    return true;
  }
};

NavState<double> state_of(const double* pose, const double* motion) {
  const Eigen::Map<const Vec<double, 9>> m(motion);
  return {PoseManifold::read(pose), m.head<3>(), m.segment<3>(3), m.tail<3>()};
}

/// An increment: pose, motion of the frame before, pose, motion of the frame itself.
struct InertialCost final : ceres::SizedCostFunction<15, 7, 9, 7, 9> {
  InertialResidual<double> residual;
  Mat<double, 15, 15> L;
  explicit InertialCost(const ImuIncrement<double>& increment)
      : residual{increment, gravity_in_world<double>()}, L(*increment.square_root_information()) {}
  bool Evaluate(const double* const* x, double* r, double** J) const override {
    const NavState<double> x_i = state_of(x[0], x[1]), x_j = state_of(x[2], x[3]);
    Eigen::Map<Vec<double, 15>> out(r);
    if (!J) {
      out = L * residual.residual(x_i, x_j);
      return true;
    }
    auto lin = residual.linearize(x_i, x_j);
    if (!lin.valid) return false;
    lin.whiten(L);
    out = lin.r;
    write(lin.J_r_i, J[0], J[1]);
    write(lin.J_r_j, J[2], J[3]);
    return true;
  }
  static void write(const Mat<double, 15, 15>& from, double* pose, double* motion) {
    write_pose_jacobian<15>(from.leftCols<6>(), pose);
    write_motion_jacobian<15>(from.rightCols<9>(), motion);
  }
};

/// The prior of the first frame: position, heading and biases.
struct FirstStateCost final : ceres::SizedCostFunction<10, 7, 9> {
  NavState<double> first;
  Mat<double, 10, 15> J0 = Mat<double, 10, 15>::Zero();
  explicit FirstStateCost(const NavState<double>& x) : first(x) {
    const WindowOptions sigmas;
    const InertialInitializerOptions biases;
    J0.block<3, 3>(0, 3).diagonal().setConstant(1 / sigmas.sigma_first_position);
    J0.block<1, 3>(3, 0) = x.T_world_body.R().row(2) / sigmas.sigma_first_rotation;
    J0.block<3, 3>(4, 9).diagonal().setConstant(1 / biases.gyro_bias_sigma);
    J0.block<3, 3>(7, 12).diagonal().setConstant(1 / biases.accel_bias_sigma);
  }
  bool Evaluate(const double* const* x, double* r, double** J) const override {
    const NavState<double> state = state_of(x[0], x[1]);
    Eigen::Map<Vec<double, 10>> out(r);
    out = J0 * minus(state, first);
    if (!J) return true;
    const Mat<double, 10, 15> by_state = J0 * minus_jacobian(state, first);
    write_pose_jacobian<10>(by_state.leftCols<6>(), J[0]);
    write_motion_jacobian<10>(by_state.rightCols<9>(), J[1]);
    return true;
  }
};

struct CeresWindow : CeresProblem {
  std::unique_ptr<Window<double>> window = std::make_unique<Window<double>>();  // the measurements
  std::vector<Vec<double, 7>> poses{keyframes};
  std::vector<Vec<double, 9>> motions{keyframes};
  std::vector<double> lambdas;
  std::vector<Vec<double, 6>> plueckers;

  CeresWindow() : lambdas(window->point_landmarks().size()), plueckers(window->line_landmarks().size()) {
    restart();
    for (Vec<double, 7>& pose : poses) problem.AddParameterBlock(pose.data(), 7, new PoseManifold);
    problem.AddResidualBlock(new FirstStateCost(window->state(0)), nullptr, poses[0].data(), motions[0].data());
    for (int k = 1; k < keyframes; ++k) {
      const std::size_t i = std::size_t(window->backend.factors().previous(k)), j = std::size_t(k);
      problem.AddResidualBlock(new InertialCost(window->backend.factors().increment(k)), nullptr, poses[i].data(),
                               motions[i].data(), poses[j].data(), motions[j].data());
    }
    for (std::size_t i = 0; i < lambdas.size(); ++i) {
      add_point(*this, window->rig.vision.camera, window->point_landmarks()[i], poses, &lambdas[i]);
    }
    for (std::size_t i = 0; i < plueckers.size(); ++i) add_line(window->line_landmarks()[i], plueckers[i].data());
    for (std::size_t k = 0; k < poses.size(); ++k) {
      options.linear_solver_ordering->AddElementToGroup(poses[k].data(), 1);
      options.linear_solver_ordering->AddElementToGroup(motions[k].data(), 1);
    }
  }
  void add_line(const Window<double>::LineStore::Landmark& landmark, double* line) {
    problem.AddParameterBlock(line, 6, new LineManifold);
    options.linear_solver_ordering->AddElementToGroup(line, 0);
    for (std::size_t slot = 0; slot < poses.size(); ++slot) {
      const auto& seen = landmark.observations[slot];
      if (!seen.valid) continue;
      add_measurement(landmark, slot, seen.pixels, line);
      if (seen.has_depth()) add_measurement(landmark, slot, seen.depth.get(), line);
    }
  }
  template <class Landmark, class Measurement>
  void add_measurement(const Landmark& landmark, std::size_t slot, const SegmentMeasurement<Measurement>& seen,
                       double* line) {
    if (int(slot) == landmark.anchor) {
      problem.AddResidualBlock(new AnchorLineCost<Measurement>(seen.measured, seen.L), new ceres::HuberLoss(2.45),
                               line);
    } else {
      problem.AddResidualBlock(new LineCost<Measurement>(seen.measured, seen.L), new ceres::HuberLoss(2.45),
                               poses[std::size_t(landmark.anchor)].data(), poses[slot].data(), line);
    }
  }
  void restart() { read(*window); }
  /// The state of one of ours.
  template <class S>
  void read(const Window<S>& w) {
    for (int k = 0; k < keyframes; ++k) {
      const NavState<double> x = w.state(k).template cast<double>();
      PoseManifold::write(x.T_world_body, poses[std::size_t(k)].data());
      motions[std::size_t(k)] << x.v_world_body, x.bias_gyro, x.bias_accel;
    }
    for (std::size_t i = 0; i < lambdas.size(); ++i) lambdas[i] = double(w.point_landmarks()[i].geometry.inverse_range);
    for (std::size_t i = 0; i < plueckers.size(); ++i) {
      LineManifold::write(w.line_landmarks()[i].geometry.line.template cast<double>(), plueckers[i].data());
    }
  }
};

#endif

}  // namespace
}  // namespace plumbline

int main(int argc, char** argv) {
#ifdef PLUMBLINE_CERES
  return plumbline::bench::compare<plumbline::Window, plumbline::CeresWindow>(argc, argv, "inertial_window_solve",
                                                                              1e-4);
#else
  benchmark::Initialize(&argc, argv);
  plumbline::bench::register_solves<plumbline::Window>("inertial_window_solve");
  benchmark::RunSpecifiedBenchmarks();
#endif
}
