#pragma once
/// Least-squares problem of a window, as levenberg_marquardt expects it: linearize, solve, try a step, accept or reject
/// it.
///                                                                                          docs/math/window.md

#include "plumbline/feature/readout_derivatives.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

template <class Backend>
struct WindowProblem {
  using S = typename Backend::S;

  Backend& self;
  const typename Backend::Sensors& rig;
  typename Backend::Landmarks& landmarks;
  SE3<S> T_body_cam;

  /// Linearizes all terms at the current state; returns the cost.
  double linearize() {
    self.begin_linearization();
    double cost = self.cost_of_frames();
    landmarks.for_each_with(self.terms_, [&](auto& store, auto& terms) {
      cost += terms.linearize(rig, store, self.window_, self.views_, self.equations_.pairs);
    });
    return cost + self.ties_.linearize(landmarks, self.views_);
  }

  /// Builds the equations of frames and rig, landmarks eliminated with damping `mu`.
  bool eliminate(double mu) {
    if (!eliminate_landmarks(mu)) return false;
    add_priors_and_factors();
    return true;
  }
  /// The part of visual rows.
  bool eliminate_landmarks(double mu) {
    self.equations_.begin();
    self.equations_.pairs.add_to(self.equations_.normal);
    for (int anchor = 0; anchor < Backend::Window::slots; ++anchor) {
      bool eliminated = true;
      self.equations_.products.reset();
      landmarks.for_each_with(self.terms_, [&](auto& store, auto& terms) {
        eliminated = eliminated && terms.eliminate(store, S(mu), anchor, self.equations_.products);
      });
      if (!eliminated) return false;
      self.equations_.products.subtract_from(self.equations_.normal, anchor, self.equations_.pairs);
    }
    self.ties_.eliminate(landmarks, self.terms_, self.equations_.pairs, self.equations_.normal);
    self.equations_.add_extrinsics(self.window_);
    return true;
  }
  void add_priors_and_factors() {
    self.rig_prior_.add_to(self.window_, self.equations_);
    self.equations_.add_priors_and_factors(self.window_, self.prior_, self.factors_);
    self.equations_.add_frame_factors(self.window_, self.frame_factors_);
  }

  /// Column of the readout time in the equations, landmarks eliminated: the derivatives of all rows by the readout time
  /// take the place of their residuals.                                                docs/math/rolling_shutter.md (4)
  bool border_by_readout(double mu, auto& column, ReadoutBorder& border) {
    self.begin_linearization();
    landmarks.for_each_with(self.terms_, [&](auto& store, auto& terms) {
      terms.exchange_residuals(rig, store, self.window_, self.views_, self.equations_.pairs, border);
    });
    self.ties_.clear_residuals();
    if (!eliminate_landmarks(mu)) return false;
    landmarks.for_each_with(self.terms_, [&](auto& store, auto& terms) { terms.subtract_eliminated(store, border); });
    column = self.equations_.normal.b();
    add_priors_and_factors();
    self.prior_.add_readout_to(self.window_, column, border);
    return true;
  }

  /// Computes the steps of frames and landmarks.
  bool solve(double mu, double& predicted_decrease) {
    if (!eliminate(mu) || !self.equations_.normal.solve(mu, self.equations_.step)) return false;
    predicted_decrease = self.equations_.normal.predicted_decrease(mu, self.equations_.step);
    landmarks.for_each_with(self.terms_, [&](auto& store, auto& terms) {
      predicted_decrease += terms.solve(store, self.equations_.pairs, self.equations_.step, Backend::Layout::dim);
    });
    predicted_decrease += self.ties_.solve(self.terms_, self.equations_.step, Backend::Layout::dim);
    return true;
  }

  /// Applies the steps; returns the cost.
  double try_step() {
    self.backup_ = self.window_;
    self.window_.move(self.equations_.step);
    landmarks.for_each_with(self.terms_, [](auto& store, auto& terms) { terms.step(store); });
    self.views_.update(self.window_, T_body_cam);
    double cost = self.cost_of_frames();
    landmarks.for_each_with(
        self.terms_, [&](auto& store, auto& terms) { cost += terms.cost(rig, store, self.window_, self.views_); });
    return cost + self.ties_.cost(landmarks, self.views_);
  }

  void accept() {}
  /// Undoes the steps.
  void reject() {
    self.window_ = self.backup_;
    self.views_.update(self.window_, T_body_cam);
    landmarks.for_each_with(self.terms_, [](auto& store, auto& terms) { terms.restore(store); });
  }
};

}  // namespace plumbline
