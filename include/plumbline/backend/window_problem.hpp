#pragma once
/// What a solver sees of a window: its cost, its equations, a step and the way back. The views are those of the state,
/// or of the trial.                                                                             docs/math/window.md

#include "plumbline/feature/readout_slopes.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

template <class Backend>
struct WindowProblem {
  using S = typename Backend::S;

  Backend& self;
  const typename Backend::Sensors& rig;
  typename Backend::Landmarks& landmarks;
  SE3<S> T_body_cam;

  double linearize() {
    self.begin_linearization();
    double cost = self.cost_of_frames();
    landmarks.for_each_with(self.terms_, [&](auto& store, auto& terms) {
      cost += terms.linearize(rig, store, self.window_, self.views_, self.equations_.pairs);
    });
    return cost + self.ties_.linearize(landmarks, self.views_);
  }

  /// The equations of the frames alone.
  bool eliminate(double mu) {
    if (!eliminate_landmarks(mu)) return false;
    add_known();
    return true;
  }
  /// Of what is seen.
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
  void add_known() {
    self.known_.add_to(self.window_, self.equations_);
    self.equations_.add_known(self.window_, self.prior_, self.links_);
  }

  /// With the slopes of all rows by the readout time in the place of their residuals: its column of the equations, and
  /// what the landmarks leave of it.                                                     rolling_shutter.md (4)
  bool border_by_readout(double mu, auto& column, ReadoutBorder& border) {
    self.begin_linearization();
    landmarks.for_each_with(self.terms_, [&](auto& store, auto& terms) {
      terms.exchange_residuals(rig, store, self.window_, self.views_, self.equations_.pairs, border);
    });
    self.ties_.forget_residuals();
    if (!eliminate_landmarks(mu)) return false;
    landmarks.for_each_with(self.terms_, [&](auto& store, auto& terms) { terms.subtract_eliminated(store, border); });
    column = self.equations_.normal.b();
    add_known();
    self.prior_.add_readout_to(self.window_, column, border);
    return true;
  }

  bool solve(double mu, double& predicted_decrease) {
    if (!eliminate(mu) || !self.equations_.normal.solve(mu, self.equations_.step)) return false;
    predicted_decrease = self.equations_.normal.predicted_decrease(mu, self.equations_.step);
    landmarks.for_each_with(self.terms_, [&](auto& store, auto& terms) {
      predicted_decrease += terms.solve(store, self.equations_.pairs, self.equations_.step, Backend::Layout::dim);
    });
    predicted_decrease += self.ties_.solve(self.terms_, self.equations_.step, Backend::Layout::dim);
    return true;
  }

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
  void reject() {
    self.window_ = self.backup_;
    self.views_.update(self.window_, T_body_cam);
    landmarks.for_each_with(self.terms_, [](auto& store, auto& terms) { terms.restore(store); });
  }
};

}  // namespace plumbline
