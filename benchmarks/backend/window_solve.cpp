// One solve of a sliding window: 10 keyframes, 150 points, every point seen with its depth by every keyframe, 1 % of
// the pixels wrong. Ceres solves the same problem (residuals, robust losses, start, tolerance; analytic Jacobians,
// DENSE_SCHUR, one thread); the program fails unless both reach the same cost.
#include "ceres_window.hpp"

#include <memory>
#include <vector>

#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/propagation/constant_velocity.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/testing/simulated_points.hpp"

namespace plumbline {
namespace {

using namespace bench;

constexpr int keyframes = 10, points = 150;

template <class S>
struct Window {
  using Sensors = Rig<Rgbd<Pinhole<S>>>;
  using Landmarks = typename Features<Points<points>>::template Landmarks<Sensors, keyframes>;
  using Backend = WindowBackend<ConstantVelocity<Sensors>, Landmarks, keyframes>;

  Sensors rig;
  Landmarks landmarks{StoreOptions{}};
  Backend backend{{}, {}};

  /// The first keyframe is exact, it defines the world; the others start 2 cm and 1 degree off.
  Window() {
    testing::SimulatedPoints scene;
    scene.outlier_share = 0.01;
    rig.vision.camera = {S(scene.camera.fx), S(scene.camera.fy), S(scene.camera.cx), S(scene.camera.cy), {}};
    scene.scatter(2 * points, {1.2, 0.9, 1.2}, 1);
    testing::Gaussian noise(2);
    for (int k = 0; k < keyframes; ++k) {
      const SE3<double> T(SO3<double>::exp({0.02 * k, -0.03 * k, 0.01 * k}), Vec<double, 3>(0.06 * k, 0.03 * k, -3.5));
      Vec<double, 6> error;
      error << 0.017 * noise.vector<3>(), 0.02 * noise.vector<3>();
      const SE3<S> start = plus(T, Vec<double, 6>(k == 0 ? 0 * error : error)).template cast<S>();
      const int slot = k == 0 ? backend.start(0, {start}) : backend.insert(k, {start}, {});
      scene.observe(landmarks.template get<0>(), T, slot, noise);
    }
  }
  LevenbergMarquardtSummary solve() { return backend.optimize(rig, rig.T_body_cam(), landmarks); }
  const auto& point_landmarks() const { return landmarks.template get<0>().landmarks(); }
};

#ifdef PLUMBLINE_CERES

struct FirstPoseCost final : ceres::SizedCostFunction<6, 7> {
  SE3<double> T_first;
  WindowOptions sigmas;
  explicit FirstPoseCost(const SE3<double>& T) : T_first(T) {}
  bool Evaluate(const double* const* x, double* r, double** J) const override {
    Vec<double, 6> inverse_sigma;
    inverse_sigma << Vec<double, 3>::Constant(1 / sigmas.sigma_first_rotation),
        Vec<double, 3>::Constant(1 / sigmas.sigma_first_position);
    const SE3<double> T = PoseManifold::read(x[0]);
    Eigen::Map<Vec<double, 6>> out(r);
    out = inverse_sigma.cwiseProduct(minus(T, T_first));
    if (J) write_pose_jacobian<6>(inverse_sigma.asDiagonal() * minus_jacobian(T, T_first), J[0]);
    return true;
  }
};

struct CeresWindow : CeresProblem {
  std::unique_ptr<Window<double>> window = std::make_unique<Window<double>>();  // the measurements
  std::vector<Vec<double, 7>> poses{keyframes};
  std::vector<double> lambdas;

  CeresWindow() : lambdas(window->point_landmarks().size()) {
    restart();
    for (Vec<double, 7>& pose : poses) problem.AddParameterBlock(pose.data(), 7, new PoseManifold);
    problem.AddResidualBlock(new FirstPoseCost(window->backend.window().T_world_body(0)), nullptr, poses[0].data());
    for (std::size_t i = 0; i < lambdas.size(); ++i) {
      add_point(*this, window->rig.vision.camera, window->point_landmarks()[i], poses, &lambdas[i]);
    }
    for (Vec<double, 7>& pose : poses) options.linear_solver_ordering->AddElementToGroup(pose.data(), 1);
  }
  void restart() { read(*window); }
  /// The state of one of ours.
  template <class S>
  void read(const Window<S>& w) {
    for (int k = 0; k < keyframes; ++k) {
      PoseManifold::write(w.backend.window().T_world_body(k).template cast<double>(), poses[std::size_t(k)].data());
    }
    for (std::size_t i = 0; i < lambdas.size(); ++i) lambdas[i] = double(w.point_landmarks()[i].geometry.inverse_range);
  }
};

#endif

}  // namespace
}  // namespace plumbline

int main(int argc, char** argv) {
#ifdef PLUMBLINE_CERES
  return plumbline::bench::compare<plumbline::Window, plumbline::CeresWindow>(argc, argv, "window_solve", 1e-6);
#else
  benchmark::Initialize(&argc, argv);
  plumbline::bench::register_solves<plumbline::Window>("window_solve");
  benchmark::RunSpecifiedBenchmarks();
#endif
}
