#pragma once
// The laws every group of lie/ obeys, over random elements that include tiny rotations and rotations close to pi.

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/lie/lie_group.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

namespace plumbline::testing {

inline Vec<double, 3> random_direction(Random& random) {
  Vec<double, 3> v;
  do {
    for (int i = 0; i < 3; ++i) v[i] = 2 * random.uniform() - 1;
  } while (!(v.squaredNorm() < 1 && v.squaredNorm() > 1e-2));
  return v.normalized();
}

/// 1e-9, ..., 1 (logarithmic), uniform up to pi, and pi - 1e-1 ... pi - 1e-9 in turns.
inline double random_angle(Random& random, int turn) {
  const double tiny = std::pow(10.0, -9 * random.uniform());
  if (turn % 3 == 0) return tiny;
  return turn % 3 == 1 ? 3.1 * random.uniform() : 3.141592653589793 - 0.1 * tiny;
}

/// Rotation by `angle`, the other entries in [-2, 2].
template <class G>
typename G::Tangent random_tangent(Random& random, double angle) {
  Vec<double, G::dof> d;
  for (int i = 3; i < G::dof; ++i) d[i] = 4 * random.uniform() - 2;
  d.template head<3>() = angle * random_direction(random);
  return d.template cast<typename G::Scalar>();
}

template <class G>
typename G::Scalar distance(const G& a, const G& b) {
  return minus(a, b).norm();
}

template <LieGroup G>
void check_group_laws() {
  using S = typename G::Scalar;
  using Tangent = typename G::Tangent;
  using Adjoint = Mat<S, G::dof, G::dof>;
  const S tolerance = std::is_same_v<S, float> ? S(4e-5) : S(1e-13);
  Random random(42);
  for (int turn = 0; turn < 600; ++turn) {
    const Tangent d = random_tangent<G>(random, random_angle(random, turn));
    const G x = G::exp(d), y = G::exp(random_tangent<G>(random, 3 * random.uniform()));
    const G z = G::exp(random_tangent<G>(random, 3 * random.uniform()));
    CAPTURE(turn, d.transpose());

    REQUIRE(distance(x * x.inverse(), G()) < tolerance);
    REQUIRE(distance(x * G(), x) < tolerance);
    const S size = 1 + (x * y * z).adjoint().norm();  // similarities enlarge rounding
    REQUIRE(distance(x * (y * z), (x * y) * z) < tolerance * size);

    // log inverts exp; close to pi the axis may come back reversed, so the elements are compared, not the vectors.
    REQUIRE(distance(G::exp(x.log()), x) < 4 * tolerance * size);
    REQUIRE(x.log().template head<3>().norm() < S(3.141593));
    if (turn % 3 != 2) {
      REQUIRE((x.log() - d).norm() < 4 * tolerance * (1 + x.adjoint().norm()));
      // x exp(e) x^-1 = exp(Ad e)
      Tangent e = random_tangent<G>(random, 0.5);
      e *= S(0.3);
      const Adjoint Ad = x.adjoint();
      REQUIRE(distance(x * G::exp(e) * x.inverse(), G::exp(Ad * e)) < 4 * tolerance * (1 + Ad.norm() * Ad.norm()));
    }
    const Adjoint product = (x * y).adjoint(), factors = x.adjoint() * y.adjoint();
    REQUIRE((product - factors).norm() < tolerance * (1 + x.adjoint().norm() * y.adjoint().norm()));

    // The retraction: minus inverts plus, and agrees with exp to first order.
    const Tangent step = S(0.5) * random_tangent<G>(random, 2);
    REQUIRE((minus(plus(y, step), y) - step).norm() < 4 * tolerance * (1 + y.adjoint().norm()));
    REQUIRE(distance(plus(y, minus(x, y)), x) < 4 * tolerance * size * (1 + y.adjoint().norm()));
    Vec<double, G::dof> small = 1e-6 * step.template cast<double>();
    REQUIRE((minus(plus(decltype(y.template cast<double>()){}, small), decltype(y.template cast<double>())::exp(small)))
                .norm() < 1e-11);
    // (3), (4) of lie/plus.hpp, off the cut at pi
    if (turn % 3 != 2) {
      const G moved = plus(y, random_tangent<G>(random, random_angle(random, turn)));
      const auto exact = y.template cast<double>();
      const auto f = [&](const auto& m) -> Vec<double, G::dof> { return minus(m, exact); };
      REQUIRE(jacobian_error(minus_jacobian(moved, y), f, moved.template cast<double>(), 1e-3) <
              (std::is_same_v<S, float> ? 2e-4 : 1e-7));
    }
  }
}

}  // namespace plumbline::testing
