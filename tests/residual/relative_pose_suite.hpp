#pragma once
// The laws of every measured relative pose: value, Jacobians, transport of its error.

#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/testing/gaussian.hpp"

namespace plumbline::test {

/// Random poses `T_world_i`, `T_world_j` and a measurement: `make(R, p, scale)` gives a pose. Every fourth state has no
/// translation, every fifth a relative rotation or an error near pi.
template <class Residual, class Make>
struct RelativePoseCase {
  using Pose = typename Residual::Pose;
  Pose T_i, T_j, measured;

  RelativePoseCase(Make&& make, testing::Gaussian& normal, int turn) {
    const auto random_scale = [&] { return std::exp(0.3 * normal()); };
    const SO3<double> R_i = SO3<double>::exp(normal.vector<3>());
    const Vec<double, 3> axis = normal.vector<3>().normalized();
    const double near_pi = std::numbers::pi - (turn % 2 == 0 ? 0.05 : 0.3), angle = turn % 5 == 0 ? near_pi : normal();
    const SO3<double> R_ij = SO3<double>::exp(Vec<double, 3>(angle * axis));
    const Vec<double, 3> p = turn % 4 == 0 ? Vec<double, 3>::Zero() : Vec<double, 3>(2 * normal.vector<3>());
    const double error = turn % 5 == 1 ? near_pi : turn % 5 == 2 ? 1e-6 : 0.5 * normal();
    const SO3<double> R_error = SO3<double>::exp(Vec<double, 3>(
        Residual::dim == 4 ? Vec<double, 3>(0, 0, error) : Vec<double, 3>(error * normal.vector<3>().normalized())));
    T_i = make(R_i, turn % 8 == 0 ? Vec<double, 3>::Zero() : Vec<double, 3>(3 * normal.vector<3>()), random_scale());
    T_j = T_i * make(R_ij, p, random_scale());
    // With heading alone the error is about the vertical, and a small tilt.
    const SO3<double> R_measured =
        Residual::dim == 4 ? R_i.inverse() * R_error * R_i * R_ij * SO3<double>::exp(0.05 * normal.vector<3>())
                           : R_ij * R_error;
    measured = make(R_measured, p + 0.3 * normal.vector<3>(), random_scale());
  }
};

/// S is the scalar under test, of `Residual<S>`; derivatives are taken of Residual<double>.
template <template <class> class Residual, class S, class Make>
void check_relative_pose(Make&& make, double tolerance) {
  constexpr int dim = Residual<S>::dim;
  using Vector = Vec<double, dim>;
  testing::Gaussian normal(17);
  for (int turn = 0; turn < 200; ++turn) {
    const RelativePoseCase<Residual<double>, Make&> c(make, normal, turn);
    const Residual<double> exact{c.measured};
    const Residual<S> residual{c.measured.template cast<S>()};
    const auto lin = residual.linearize(c.T_i.template cast<S>(), c.T_j.template cast<S>());
    REQUIRE(lin.valid);
    REQUIRE(lin.r == residual.residual(c.T_i.template cast<S>(), c.T_j.template cast<S>()));
    const auto error = [&](const auto& J, auto&& f) {
      Mat<double, dim, dim> numeric;
      const double h = 1e-3;
      for (int n = 0; n < dim; ++n) {
        const auto at = [&](double x) -> Vector { return f(Vector(x * Vector::Unit(n))); };
        numeric.col(n) = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
      }
      return (numeric - J.template cast<double>()).norm() / std::max(1.0, numeric.norm());
    };
    REQUIRE(error(lin.J_r_i, [&](const Vector& d) {
              return exact.residual(Residual<double>::moved(c.T_i, d), c.T_j);
            }) < tolerance);
    REQUIRE(error(lin.J_r_j, [&](const Vector& d) {
              return exact.residual(c.T_i, Residual<double>::moved(c.T_j, d));
            }) < tolerance);
    // An error of T_j moves a node that is fixed to it by transport(T_j, T_k) times that error.
    const auto T_k = c.T_j * make(SO3<double>::exp(normal.vector<3>()), normal.vector<3>(), 1.3);
    const Residual<double> of_k{c.T_i.inverse() * T_k};
    REQUIRE(error(Residual<S>::transport(c.T_j.template cast<S>(), T_k.template cast<S>()), [&](const Vector& d) {
              return of_k.residual(c.T_i, Residual<double>::moved(c.T_j, d) * (c.T_j.inverse() * T_k));
            }) < tolerance);
    // A right increment of the measurement is the residual with the other sign, where it is small.
    const Vector d = 1e-4 * normal.vector<dim>();
    const Residual<double> near{c.T_i.inverse() * Residual<double>::moved(c.T_j, d)};
    REQUIRE((near.residual(c.T_i, c.T_j) + d).norm() < 1e-6);
    REQUIRE(Residual<double>{c.T_i.inverse() * c.T_j}.residual(c.T_i, c.T_j).norm() < 1e-12);
  }
  RelativePoseCase<Residual<double>, Make&> c(make, normal, 1);
  const auto bad = make(SO3<double>(), Vec<double, 3>(std::numeric_limits<double>::quiet_NaN(), 0, 0), 1.0);
  REQUIRE(
      !Residual<S>{c.measured.template cast<S>()}.linearize(c.T_i.template cast<S>(), bad.template cast<S>()).valid);
}

}  // namespace plumbline::test
