#pragma once
/// Backend policy: Levenberg-Marquardt over a window of K keyframes and the landmarks they see, with marginalization of
/// the keyframes that leave and first-estimate Jacobians.                                  docs/math/window.md
///
/// One call of `optimize` minimizes  |r0 + J0 e|^2 / 2 + the terms of all features  over the K poses; landmarks are
/// eliminated one by one. `marginalize` turns a keyframe, and the landmarks anchored in it, into the next (r0, J0).
///
/// With an IMU a frame's block is [pose, velocity, biases], docs/math/inertial_window.md, and the cost has the chain's
/// terms as soon as `start_inertial` was called; before, velocities and biases rest where they are.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <type_traits>

#include "plumbline/backend/inertial_chain.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/mapping/frame_window.hpp"
#include "plumbline/mapping/window_views.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/solver/levenberg_marquardt.hpp"
#include "plumbline/solver/marginalization.hpp"
#include "plumbline/solver/normal_equations.hpp"
#include "plumbline/solver/relative_equations.hpp"

namespace plumbline {

struct WindowOptions {
  LevenbergMarquardtOptions solver;
  double sigma_first_rotation = 1e-3;  ///< prior on the first pose, which is the world's origin [rad]
  double sigma_first_position = 1e-3;  ///< [m]
  InertialOptions inertial;            ///< of rigs with an IMU
};

/// Stands for the inertial chain where there is no IMU.
struct NoInertialChain {
  explicit NoInertialChain(const InertialOptions&) {}
};

template <SensorRig Sensors, class FeatureSet, int K>
class WindowBackend {
 public:
  using S = typename Sensors::Scalar;
  using Window = FrameWindow<S, K>;
  using Options = WindowOptions;
  static constexpr int block_dim = Sensors::state_dim;
  static constexpr bool has_imu = Sensors::has_imu;
  using Inertial = std::conditional_t<has_imu, InertialChain<S, K>, NoInertialChain>;

  explicit WindowBackend(const Options& options) : options_(options), inertial_(options.inertial) {
    prior_H_.resize(dim, dim);
  }

  const Window& window() const { return window_; }
  const Inertial& inertial() const { return inertial_; }

  /// Forgets everything and begins with one keyframe at a pose that defines the world. Returns its slot.
  int start(TimeNs t_ns, const SE3<S>& T_world_body) {
    window_.clear();
    inertial_started_ = false;
    const int slot = window_.insert(t_ns, T_world_body);
    if constexpr (has_imu) inertial_.insert(slot, {T_world_body}, -1, {}, false);
    Mat<double, 6, 6> J;
    J.setZero();
    for (int k = 0; k < 6; ++k) J(k, k) = 1 / (k < 3 ? options_.sigma_first_rotation : options_.sigma_first_position);
    set_prior(slot, J);
    order_parameters();
    build_equations();  // so that a covariance is defined before the first optimization
    return slot;
  }

  int insert(TimeNs t_ns, const SE3<S>& T_world_body) { return window_.insert(t_ns, T_world_body); }

  /// A frame with its inertial state, the increment since the frame in slot `previous` (-1: none) and whether the body
  /// stood still since then.
  int insert(TimeNs t_ns, const NavState<S>& x, int previous, const Preintegration<S>& increment,
             bool at_rest) requires has_imu {
    const int slot = window_.insert(t_ns, x.T_world_body);
    inertial_.insert(slot, x, previous, increment, at_rest);
    return slot;
  }

  /// The state of a frame.
  NavState<S> state(int slot) const requires has_imu { return inertial_.state(window_, slot); }

  /// Gives frame k of the window the state `state_of(k)` and starts anew from there: no prior but the position and
  /// heading of the oldest frame and a belief about its biases. From now on the IMU takes part.
  void start_inertial(auto&& state_of) requires has_imu {
    int oldest = window_.newest();
    for (int k = 0; k < K; ++k) {
      if (!window_[k].used) continue;
      const NavState<S> x = state_of(k);
      window_.pose(k) = WindowPose<S>(x.T_world_body);
      inertial_.set_motion(k, x);
      if (window_[k].sequence < window_[oldest].sequence) oldest = k;
    }
    inertial_.follow_biases(window_);
    inertial_started_ = true;
    const Mat<S, 3, 3> R = window_[oldest].pose.value().R();
    Mat<double, 10, 15> J;
    J.setZero();
    for (int k = 0; k < 3; ++k) {
      J(k, 3 + k) = 1 / options_.sigma_first_position;
      J(3, k) = double(R(2, k)) / options_.sigma_first_rotation;  // heading: the vertical part of R dphi
      J(4 + k, 9 + k) = 1 / options_.inertial.start_gyro_bias_sigma;
      J(7 + k, 12 + k) = 1 / options_.inertial.start_accel_bias_sigma;
    }
    set_prior(oldest, J);
  }

  /// Velocities that the positions and the increments between them ask for.
  void guess_velocities() requires has_imu { inertial_.guess_velocities(window_); }

  /// Frees the slot of a frame that no landmark is anchored in and no prior knows, without a trace.
  void drop(FeatureSet& features, int slot) {
    features.for_each([&](auto& map) { map.remove_keyframe(slot); });
    if constexpr (has_imu) inertial_.remove(slot);
    window_.remove(slot);
  }

  LevenbergMarquardtSummary optimize(const Sensors& rig, const SE3<S>& T_body_cam, FeatureSet& features,
                                     const LevenbergMarquardtOptions& solver) {
    if constexpr (has_imu) {
      if (inertial_started_) inertial_.follow_biases(window_);
    }
    order_parameters();
    Problem problem{*this, rig, features, T_body_cam};
    const LevenbergMarquardtSummary summary = levenberg_marquardt(problem, solver);
    views_.update(window_, T_body_cam);
    for_each(features, [&](auto& map, auto& terms) { terms.finish(rig, map, window_, views_); });
    // For the covariance: here, not a step before, and what damped the landmarks is no knowledge.
    problem.linearize();
    problem.eliminate(solver.mu_min);
    return summary;
  }
  LevenbergMarquardtSummary optimize(const Sensors& rig, FeatureSet& features) {
    return optimize(rig, rig.T_body_cam(), features, options_.solver);
  }

  /// Turns the keyframe in `slot`, all landmarks anchored in it and its observations of others into prior information
  /// on the keyframes that stay.
  void marginalize(const Sensors& rig, FeatureSet& features, int slot) {
    marginalize(rig, rig.T_body_cam(), features, slot);
  }
  void marginalize(const Sensors& rig, const SE3<S>& T_body_cam, FeatureSet& features, int slot) {
    linearize_views(T_body_cam);
    marginalizer_.reset(dim);
    marginalizer_.add_rows(prior_.J0, prior_.r0);
    const Vec<double, dim> e = corrections();
    if constexpr (has_imu) {
      if (inertial_started_) {
        inertial_.for_each_row(window_, slot, [&](int i, const auto& J_i, int j, const auto& J_j, const auto& r) {
          Vec<double, std::remove_cvref_t<decltype(r)>::RowsAtCompileTime> r0;
          for (int k = 0; k < int(r.size()); ++k) {  // the prior's residual belongs to e = 0
            r0[k] = double(r[k]);
            for (int c = 0; c < block_dim; ++c) {
              r0[k] -= double(J_i(k, c)) * e[i * block_dim + c] + double(J_j(k, c)) * e[j * block_dim + c];
            }
          }
          marginalizer_.add_rows(J_i, i * block_dim, J_j, j * block_dim, r0);
        });
      }
      inertial_.remove(slot);
    }
    for_each(features, [&](auto& map, auto& terms) {
      terms.for_each_leaving(slot, rig, map, window_, views_, [&](const auto& landmark) {
        constexpr int columns = std::remove_cvref_t<decltype(landmark)>::landmark_dim;
        static_assert(columns <= max_landmark_dim && std::remove_cvref_t<decltype(landmark)>::max_rows <= max_rows);
        const int rows = landmark.rows();
        work_.resize(rows, columns + dim + 1);
        const int rank = landmark.reduced_rows(work_, pairs_, block_dim);
        if (rows <= rank) return;
        Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_rows, 1> r(rows - rank);
        for (int k = rank; k < rows; ++k) r[k - rank] = work_(k, columns + dim);
        for (int c = 0; c < dim; ++c) {  // the prior's residual belongs to e = 0
          for (int k = rank; k < rows; ++k) r[k - rank] -= work_(k, columns + c) * e[c];
        }
        marginalizer_.add_rows(work_.block(rank, columns, rows - rank, dim), r);
      });
      map.remove_keyframe(slot);
    });
    // The prior keeps a column for every slot; those of free slots are zero.
    const int first = slot * block_dim;
    if (marginalizer_.marginalize(first, block_dim, reduced_)) {
      prior_.widen(reduced_, first, block_dim);
    } else {
      prior_.forget(first, block_dim);
    }
    prior_.information(prior_H_);
    window_.remove(slot);
    for (int k = 0; k < K; ++k) {
      if (window_[k].used && prior_.knows(k * block_dim, block_dim)) fix_linearization_point(k);
    }
  }

  /// The keyframe whose view the others replace best: far from the newest, near to the others, distances in units of
  /// the scene's depth and of the field of view. Never one of the two newest.
  int most_redundant(S mean_depth) const {
    const int newest = window_.newest();
    int second = -1, worst = -1;
    for (int k = 0; k < K; ++k) {
      if (window_[k].used && k != newest && (second < 0 || window_[k].sequence > window_[second].sequence)) second = k;
    }
    S worst_score = S(-1);
    for (int k = 0; k < K; ++k) {
      if (!window_[k].used || k == newest || k == second) continue;
      S crowd = S(0);
      for (int j = 0; j < K; ++j) {
        if (window_[j].used && j != k) crowd += S(1) / (S(0.02) + distance(k, j, mean_depth));
      }
      const S score = std::sqrt(distance(k, newest, mean_depth)) * crowd;
      if (score > worst_score) {
        worst_score = score;
        worst = k;
      }
    }
    return worst;
  }

  int oldest() const {
    int found = window_.newest();
    for (int k = 0; k < K; ++k) {
      if (window_[k].used && window_[k].sequence < window_[found].sequence) found = k;
    }
    return found;
  }

  /// Covariance of the newest frame's pose [dphi, dp] given the whole window, or of more of its block, [pose, velocity,
  /// biases]; false when it is not defined.
  template <int Dim>
  bool newest_covariance(Mat<S, Dim, Dim>& covariance) const {
    static_assert(Dim <= block_dim);
    Mat<double, block_dim, block_dim> block;
    if (!equations_.covariance_block(window_.newest(), block)) return false;
    for (int c = 0; c < Dim; ++c) {
      for (int r = 0; r < Dim; ++r) covariance(r, c) = S(block(r, c));
    }
    return true;
  }

 private:
  static constexpr int dim = K * block_dim;
  static constexpr int max_rows = 6 * K, max_landmark_dim = 4;  ///< of one landmark of any kind
  using Equations = NormalEquations<double, block_dim, K>;
  using Pairs = RelativeEquations<double, 6, K>;
  template <class Map>
  using Terms = typename Map::template WindowTerms<6>;  // features see poses alone

  /// What the solver sees of the window.
  struct Problem {
    WindowBackend& self;
    const Sensors& rig;
    FeatureSet& features;
    SE3<S> T_body_cam;

    double linearize() {
      self.linearize_views(T_body_cam);
      self.pairs_.reset();
      double cost = self.prior_cost() + self.inertial_cost();
      self.for_each(features, [&](auto& map, auto& terms) {
        cost += terms.linearize(rig, map, self.window_, self.views_, self.pairs_);
      });
      return cost;
    }

    /// The equations of the frames alone.
    bool eliminate(double mu) {
      self.build_equations();
      self.pairs_.add_to(self.equations_);
      bool eliminated = true;
      self.for_each(features, [&](auto& map, auto& terms) {
        eliminated = eliminated && terms.eliminate(map, S(mu), self.pairs_, self.equations_);
      });
      return eliminated;
    }

    bool solve(double mu, double& predicted_decrease) {
      if (!eliminate(mu) || !self.equations_.solve(mu, self.step_)) return false;
      predicted_decrease = self.equations_.predicted_decrease(mu, self.step_);
      self.for_each(features, [&](auto& map, auto& terms) { predicted_decrease += terms.solve(map, self.step_); });
      return true;
    }

    double try_step() {
      self.backup_ = self.window_;
      if constexpr (has_imu) self.inertial_.backup();
      for (int k = 0; k < K; ++k) {
        if (!self.window_[k].used) continue;
        Vec<S, 6> pose;
        for (int c = 0; c < 6; ++c) pose[c] = S(self.step_[k * block_dim + c]);
        self.window_.pose(k).add(pose);
        if constexpr (has_imu) {
          Vec<S, 9> motion;
          for (int c = 0; c < 9; ++c) motion[c] = S(self.step_[k * block_dim + 6 + c]);
          self.inertial_.step(k, motion);
        }
      }
      self.for_each(features, [](auto& map, auto& terms) { terms.step(map); });
      self.views_.update(self.window_, T_body_cam);
      double cost = self.prior_cost() + self.inertial_cost();
      self.for_each(features, [&](auto& map, auto& terms) { cost += terms.cost(rig, map, self.window_, self.views_); });
      return cost;
    }

    void accept() {}
    void reject() {
      self.window_ = self.backup_;
      if constexpr (has_imu) self.inertial_.restore();
      self.for_each(features, [&](auto& map, auto& terms) { terms.restore(map); });
    }
  };

  void for_each(FeatureSet& features, auto&& visit) {
    features.for_each([&](auto& map) { visit(map, std::get<Terms<std::remove_cvref_t<decltype(map)>>>(terms_)); });
  }

  /// The corrections e of all poses, by slot.
  Vec<double, dim> corrections() const {
    Vec<double, dim> e;
    e.setZero();
    for (int k = 0; k < K; ++k) {
      if (!window_[k].used) continue;
      for (int c = 0; c < 6; ++c) e[k * block_dim + c] = double(window_[k].pose.correction()[c]);
      if constexpr (has_imu) {
        for (int c = 0; c < 9; ++c) e[k * block_dim + 6 + c] = double(inertial_.correction(k)[c]);
      }
    }
    return e;
  }

  S distance(int a, int b, S mean_depth) const {
    const Vec<S, 6> d = minus(window_[a].pose.value(), window_[b].pose.value());
    return d.template head<3>().norm() + d.template tail<3>().norm() / mean_depth;
  }

  void linearize_views(const SE3<S>& T_body_cam) {
    views_.update(window_, T_body_cam);
    views_.set_transports(window_, pairs_);
  }

  double prior_cost() const { return prior_.residual(corrections()).squaredNorm() / 2; }

  double inertial_cost() const {
    if constexpr (has_imu) {
      if (inertial_started_) return inertial_.cost(window_);
    }
    return 0;
  }

  void fix_linearization_point(int slot) {
    window_.pose(slot).fix_linearization_point();
    if constexpr (has_imu) inertial_.fix_linearization_point(slot);
  }

  /// A prior on the leading parameters of one frame alone, which is its own linearization point.
  template <int Rows, int Columns>
  void set_prior(int slot, const Mat<double, Rows, Columns>& J) {
    prior_.J0.resize(Rows, dim);
    prior_.J0.setZero();
    for (int c = 0; c < Columns; ++c) {
      for (int k = 0; k < Rows; ++k) prior_.J0(k, slot * block_dim + c) = J(k, c);
    }
    prior_.r0.setZero(Rows);
    prior_.information(prior_H_);
    fix_linearization_point(slot);
  }

  /// The order of elimination: velocities and biases from the newest to the oldest, each of which is linked to the next
  /// one alone, then the poses. The newest pose is last: its covariance is the end of the factor.
  void order_parameters() {
    std::array<int, K> slots;  // oldest first, those that are free before all
    for (int k = 0; k < K; ++k) slots[k] = k;
    const auto age = [this](int k) { return window_[k].used ? std::int64_t(window_[k].sequence) : -1; };
    std::sort(slots.begin(), slots.end(), [&](int a, int b) { return age(a) < age(b); });
    typename Equations::Order order;
    int n = 0;
    for (int k = K - 1; k >= 0; --k) {
      for (int c = 6; c < block_dim; ++c) order[n++] = std::int16_t(slots[k] * block_dim + c);
    }
    for (const int slot : slots) {
      for (int c = 0; c < 6; ++c) order[n++] = std::int16_t(slot * block_dim + c);
    }
    equations_.set_order(order);
  }

  /// The prior, the inertial rows, and an identity for every parameter that nothing speaks of.
  void build_equations() {
    equations_.reset(K, prior_H_);
    equations_.add_gradient(prior_.gradient(prior_.residual(corrections())));
    for (int k = 0; k < K; ++k) {
      if (window_[k].used && (!has_imu || inertial_started_)) continue;
      Mat<double, block_dim, block_dim> H;
      H.setZero();
      for (int c = window_[k].used ? 6 : 0; c < block_dim; ++c) H(c, c) = 1;
      equations_.add_block(k, k, H);
    }
    if constexpr (has_imu) {
      if (!inertial_started_) return;
      inertial_.for_each_row(window_, -1, [&](int i, const auto& J_i, int j, const auto& J_j, const auto& r) {
        equations_.add(i, J_i, j, J_j, r, 1.0);
      });
    }
  }

  Options options_;
  Window window_, backup_;
  [[no_unique_address]] Inertial inertial_;
  bool inertial_started_ = false;
  WindowViews<S, K> views_;
  Prior<dim> prior_;
  BoundedMatrix<double, dim, dim> prior_H_;  ///< J0^T J0, which does not change until the next keyframe leaves
  Marginalizer<dim, 64> marginalizer_;
  Prior<dim> reduced_;
  Equations equations_;
  Pairs pairs_;
  typename Equations::Vector step_;
  typename FeatureSet::template TupleOf<Terms> terms_;
  BoundedMatrix<double, max_rows, max_landmark_dim + dim + 1> work_;
};

/// K keyframes.
template <int K>
struct SlidingWindow {
  static_assert(K >= 3, "plumbline: a window needs at least three keyframes");
  static constexpr int slots = K;

  template <SensorRig Sensors, class FeatureSet>
  using Backend = WindowBackend<Sensors, FeatureSet, K>;
};

}  // namespace plumbline
