// What lines add to a window against dense references from numeric derivatives, in double.

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include <Eigen/Cholesky>

#include "catch.hpp"
#include "feature/seen_lines.hpp"
#include "plumbline/feature/window_terms.hpp"
#include "plumbline/solver/normal_equations.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;
using test::SeenLines;

namespace {

template <class S>
struct Scene : SeenLines<S> {
  using Base = SeenLines<S>;
  using Landmark = typename Base::Landmark;
  using Observation = typename Base::Observation;
  using Terms = WindowTerms<typename Base::Store>;
  using Equations = NormalEquations<double, 6, Base::slots>;
  static constexpr int pose_dim = 6 * Base::slots;
  std::unique_ptr<Terms> terms = std::make_unique<Terms>();
  WindowViews<S, Base::slots> views;
  typename Terms::Pairs pairs;

  /// Keyframes and lines off their true places, two keyframes with fixed linearization points.
  explicit Scene(int count, double disturbance = 1) : Base(count) {
    testing::Gaussian noise(11);
    for (int k = 0; k < Base::used; ++k) {
      Vec<double, 6> error;
      error << 0.002 * noise.vector<3>(), 0.004 * noise.vector<3>();
      Base::window.state(k).add((disturbance * error).template cast<S>());
      if (k >= 2) continue;
      Base::window.state(k).fix_first_estimates();
      Base::window.state(k).add((0.5 * disturbance * error).template cast<S>());
    }
    for (Landmark& landmark : Base::store->landmarks()) {
      Vec<double, 4> error;
      error << 0.004 * noise.vector<3>(), 0.003 * noise();
      landmark.geometry.line = landmark.geometry.line.plus((disturbance * error).template cast<S>());
    }
    update();
  }
  void update() {
    views.update(Base::window, Base::T_body_cam.template cast<S>());
    views.set_transports(Base::window, pairs);
  }

  double linearize() {
    pairs.reset();
    return terms->linearize(Base::rig, *Base::store, Base::window, views, pairs);
  }
  /// All that the lines add to the equations.
  bool eliminate(S mu, Equations& equations) {
    pairs.add_to(equations);
    return terms->eliminate(*Base::store, mu, pairs, equations);
  }
  double cost() const { return terms->cost(Base::rig, *Base::store, Base::window, views); }

  /// Unwhitened errors of one observation.
  static Vec<double, 2> errors(const SE3<double>& T_cam_anchor, const Line3<double>& line, const Observation& seen,
                               bool depth) {
    const Plucker<double> in_cam = T_cam_anchor * line.plucker();
    return depth ? test::depth_of(seen).residual(in_cam) : test::pixels_of(seen).residual(in_cam);
  }
};

/// Whitened, weighted rows [lines | poses] of everything.
template <class S>
struct Dense {
  int lines;
  Eigen::MatrixXd J;
  Eigen::VectorXd r;
  double cost = 0;

  explicit Dense(const Scene<S>& scene) : lines(4 * int(scene.store->landmarks().size())) {
    J.resize(0, lines + Scene<S>::pose_dim);
    const Huber<double> loss{2.45};
    for (std::size_t i = 0; i < scene.store->landmarks().size(); ++i) {
      const auto& landmark = scene.store->landmarks()[i];
      if (!landmark.takes_part()) continue;
      const Line3<double> line = landmark.geometry.line.template cast<double>();
      const int a = landmark.anchor;
      for (int k = 0; k < scene.used; ++k) {
        const typename Scene<S>::Observation& seen = landmark.observations[std::size_t(k)];
        if (!seen.valid) continue;
        for (const bool depth : {false, true}) {
          if (depth && !seen.has_depth()) continue;
          const auto relative = [&](const SE3<double>& T_a, const SE3<double>& T_k) {
            return k == a ? SE3<double>() : (T_k * scene.T_body_cam).inverse() * T_a * scene.T_body_cam;
          };
          const auto current = [&](int slot) { return scene.window.T_world_body(slot).template cast<double>(); };
          const auto linear = [&](int slot) {
            return scene.window[slot].state.template get<state::Pose>().first_estimate().template cast<double>();
          };
          const auto e = [&](const SE3<double>& T_a, const SE3<double>& T_k, const Line3<double>& x) {
            return Scene<S>::errors(relative(T_a, T_k), x, seen, depth);
          };
          const Mat<double, 2, 2> L = (depth ? seen.depth.get().L : seen.pixels.L).template cast<double>();
          const Vec<double, 2> whitened = L * e(current(a), current(k), line);
          const double s = whitened.squaredNorm(), w = std::sqrt(loss.weight(s));
          const Eigen::Index n = append(2);
          J.block(n, 4 * Eigen::Index(i), 2, 4) =
              w * L *
              testing::numeric_jacobian<2, 4>([&](const Line3<double>& x) { return e(current(a), current(k), x); },
                                              line, 1e-5);
          if (k != a) {
            const Mat<double, 2, 6> J_target =
                w * L *
                testing::numeric_jacobian<2, 6>([&](const SE3<double>& T) { return e(current(a), T, line); },
                                                current(k), 1e-5);
            J.block(n, lines + 6 * k, 2, 6) = J_target;
            J.block(n, lines + 6 * a, 2, 6) = -J_target * (linear(k).inverse() * linear(a)).adjoint();
          }
          r.tail(2) = w * whitened;
          cost += loss.rho(s) / 2;
        }
      }
    }
  }
  /// On line i, the poses given.
  Eigen::MatrixXd information(int i) const {
    const Eigen::MatrixXd J_i = J.middleCols(4 * i, 4);
    return J_i.transpose() * J_i;
  }
  Eigen::Index append(int rows) {
    const Eigen::Index n = r.size();
    J.conservativeResize(n + rows, Eigen::NoChange);
    r.conservativeResize(n + rows);
    J.bottomRows(rows).setZero();
    r.tail(rows).setZero();
    return n;
  }
};

}  // namespace

TEMPLATE_TEST_CASE("window_terms (lines): cost and steps are those of the dense problem", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 3e-3 : 1e-6;
  for (const double mu : {0.0, 1e-3}) {
    Scene<S> scene(10);
    scene.store->landmarks()[1].observations[2].clear_depth();
    scene.store->landmarks()[2].observations[3].valid = false;
    scene.store->landmarks()[3].located = false;
    for (int k = 1; k < 4; ++k) scene.store->landmarks()[4].observations[std::size_t(k)].valid = false;
    const Dense<S> dense(scene);
    REQUIRE(std::abs(scene.linearize() - dense.cost) < tolerance * dense.cost);
    REQUIRE(std::abs(scene.cost() - dense.cost) < tolerance * dense.cost);

    typename Scene<S>::Equations equations;
    equations.reset(scene.slots);
    for (int k = 0; k < scene.slots; ++k) {
      equations.add(k, Mat<double, 6, 6>(10 * Mat<double, 6, 6>::Identity()), Vec<double, 6>(Vec<double, 6>::Zero()),
                    1.0);
    }
    REQUIRE(scene.eliminate(S(mu), equations));
    typename Scene<S>::Equations::Vector d;
    REQUIRE(equations.solve(0, d));
    const double predicted = equations.predicted_decrease(0, d) + scene.terms->solve(*scene.store, scene.pairs, d, 6);

    Eigen::MatrixXd H = dense.J.transpose() * dense.J;
    H.diagonal().head(dense.lines).array() += 1;  // (31)
    H.diagonal().tail(scene.pose_dim).array() += 100;
    Eigen::MatrixXd damped = H;
    for (int i = 0; i < dense.lines; ++i) damped(i, i) += mu * damping_scale(H(i, i));
    const Eigen::VectorXd b = dense.J.transpose() * dense.r, step = -damped.ldlt().solve(b);
    REQUIRE((d - step.tail(scene.pose_dim)).norm() < tolerance * step.tail(scene.pose_dim).norm());
    const double decrease = -step.dot(b) - 0.5 * step.dot(H * step);
    REQUIRE(std::abs(predicted - decrease) < tolerance * decrease);

    const auto before = scene.store->landmarks();
    const double cost = scene.cost();
    scene.terms->step(*scene.store);
    for (std::size_t i = 0; i < before.size(); ++i) {
      const Vec<double, 4> made = minus(scene.store->landmarks()[i].geometry.line.template cast<double>(),
                                        before[i].geometry.line.template cast<double>());
      REQUIRE((made - step.segment<4>(4 * Eigen::Index(i))).norm() < 1e-4 + tolerance * step.norm());
    }
    scene.terms->restore(*scene.store);
    REQUIRE(scene.cost() == cost);
  }
}

TEST_CASE("window_terms (lines): lines converge to the truth between true poses") {
  Scene<double> scene(12, 0);
  testing::Gaussian noise(5);
  for (std::size_t i = 0; i < 12; ++i) {
    auto& landmark = scene.store->landmarks()[i];
    for (int k = landmark.anchor; k < scene.used; ++k) {
      landmark.observations[std::size_t(k)] = scene.observe(scene.p_world[i], scene.q_world[i], k, 0, noise);
      if (i % 3 != 0) landmark.observations[std::size_t(k)].clear_depth();  // these by parallax alone
    }
    landmark.geometry.line = landmark.geometry.line.plus(0.02 * Vec<double, 4>{noise(), noise(), noise(), noise()});
  }
  for (int iteration = 0; iteration < 8; ++iteration) {
    scene.linearize();
    Scene<double>::Equations equations;
    equations.reset(scene.slots);
    REQUIRE(scene.eliminate(0, equations));
    scene.terms->solve(*scene.store, scene.pairs, Eigen::VectorXd::Zero(scene.pose_dim).eval(), 6);
    scene.terms->step(*scene.store);
  }
  REQUIRE(scene.cost() < 1e-6);
  for (std::size_t i = 0; i < 12; ++i) {
    const auto& landmark = scene.store->landmarks()[i];
    CAPTURE(i);
    REQUIRE(minus(landmark.geometry.line, scene.true_line(i, landmark.anchor)).norm() < 2e-3);
  }
}

TEST_CASE("window_terms (lines): finish gives the covariance and drops what does not belong") {
  Scene<double> scene(5, 0);
  testing::Gaussian noise(2);
  auto& landmarks = scene.store->landmarks();
  const Vec<double, 3> off(0.3, 0.3, 0);
  landmarks[1].observations[3] = scene.observe(scene.p_world[1] + off, scene.q_world[1], 3, 0, noise);
  auto wrong_depth = landmarks[2].observations[2].depth.get();
  wrong_depth.measured.inverse_depth_measured[0] += 0.3;
  landmarks[2].observations[2].depth.set(wrong_depth);
  landmarks[3].geometry.line =
      landmarks[3].geometry.line.plus(Vec<double, 4>::Constant(std::numeric_limits<double>::quiet_NaN()));
  for (auto& seen : landmarks[4].observations) {  // seen so badly that its distance is unknown
    seen.pixels.L *= 1e-3;
    seen.clear_depth();
  }
  scene.terms->finish(scene.rig, *scene.store, scene.window, scene.views, scene.pairs);
  REQUIRE(landmarks[0].located);
  REQUIRE(landmarks[0].observation_count() == 4);
  Eigen::MatrixXd information = Dense<double>(scene).information(0);
  information.diagonal().array() += 1;  // (31)
  const Eigen::MatrixXd expected = information.ldlt().solve(Eigen::MatrixXd::Identity(4, 4));
  REQUIRE((landmarks[0].geometry.covariance - expected).norm() < 1e-5 * expected.norm());
  REQUIRE_FALSE(landmarks[1].observations[3].valid);
  REQUIRE(landmarks[1].observations[2].valid);
  REQUIRE(landmarks[2].observations[2].valid);
  REQUIRE_FALSE(landmarks[2].observations[2].has_depth());
  for (const std::size_t i : {3u, 4u}) {
    REQUIRE_FALSE(landmarks[i].located);
    REQUIRE_FALSE(landmarks[i].current.valid);
  }
}

TEST_CASE("window_terms (lines): views that leave a line open do not stop the window") {
  Scene<double> scene(4, 0);
  for (auto& landmark : scene.store->landmarks()) {
    for (auto& seen : landmark.observations) seen.clear_depth();
  }
  for (int k = 0; k < scene.used; ++k) {  // no parallax at all
    for (auto& landmark : scene.store->landmarks()) {
      auto& seen = landmark.observations[std::size_t(k)];
      if (seen.valid) seen = landmark.seen_by_anchor();
    }
  }
  for (int k = 1; k < scene.used; ++k) scene.window.state(k) = scene.window[0].state;
  scene.update();
  scene.linearize();
  Scene<double>::Equations equations;
  equations.reset(scene.slots);
  REQUIRE(scene.eliminate(0, equations));
  REQUIRE(equations.H().allFinite());
}

TEST_CASE("window_terms (lines): what leaves with a keyframe") {
  Scene<double> scene(6);
  scene.store->landmarks()[5].observations[2].valid = false;
  int anchored = 0;
  scene.terms->for_each_leaving(0, scene.rig, *scene.store, scene.window, scene.views,
                                [&](const auto& rows, const auto&) {
                                  ++anchored;
                                  REQUIRE(rows.rows() == 16);  // all four views
                                });
  REQUIRE(anchored == 3);  // and those of keyframe 1 are not seen by keyframe 0

  int tied = 0;
  Mat<double, 12, 12> information = Mat<double, 12, 12>::Zero();  // on keyframes 1 and 2
  scene.terms->for_each_leaving(2, scene.rig, *scene.store, scene.window, scene.views,
                                [&](const auto& rows, const auto&) {
                                  ++tied;
                                  REQUIRE(rows.rows() == 6);  // the anchor's pixels and its own pixels and depth
                                  Eigen::Matrix<double, 30, 4 + 30 + 1> work;
                                  const int rank = rows.reduced_rows(work, scene.pairs);
                                  REQUIRE(rank == 4);
                                  const Eigen::MatrixXd J = work.block(rank, 4 + 6, rows.rows() - rank, 12);
                                  information += J.transpose() * J;
                                });
  REQUIRE(tied == 5);
  // Two keyframes are related by lines with depth; the pose of both together is free.
  const Eigen::LDLT<Mat<double, 6, 6>> relative(information.bottomRightCorner<6, 6>());
  REQUIRE(relative.vectorD().minCoeff() > 1);
  REQUIRE(scene.store->landmarks().size() == 6);
}
