#include "plumbline/tracking/increment_prior.hpp"

#include <cmath>

#include "catch.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/testing/gaussian.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;

namespace {
Vec<double, 6> sigma() {
  Vec<double, 6> out;
  out << 0.01, 0.02, 0.015, 0.05, 0.03, 0.08;
  return out;
}
const SE3<double> T_predicted(SO3<double>::exp({0.1, -0.2, 0.05}), {0.3, -0.1, 0.2});
}  // namespace

TEMPLATE_TEST_CASE("increment_prior: value and Jacobian", "", float, double) {
  using S = TestType;
  const auto exact = IncrementPrior<double>::of(T_predicted, sigma());
  const auto prior = IncrementPrior<S>::of(T_predicted.cast<S>(), Vec<S, 6>(sigma().cast<S>()));
  REQUIRE(prior.valid);
  CHECK(prior.linearize(T_predicted.cast<S>()).r.norm() < S(1e-4));
  Vec<double, 6> d;
  d << 0.05, -0.03, 0.04, 0.02, 0.1, -0.05;
  const SE3<double> T = plus(T_predicted, d);
  const auto value = [&](const SE3<double>& x) { return exact.linearize(x).r; };
  CHECK(testing::jacobian_error(prior.linearize(T.cast<S>()).J, value, T) < (sizeof(S) == 4 ? 1e-4 : 1e-8));
  CHECK((prior.linearize(T.cast<S>()).r.template cast<double>() - value(T)).norm() < (sizeof(S) == 4 ? 1e-3 : 1e-12));
}

TEST_CASE("increment_prior: its weight is that of errors of the current body") {
  const SE3<double> T_world_previous(SO3<double>::exp({0.3, 0.1, -2}), {1, 2, 3});
  const SE3<double> T_world_current = T_world_previous * T_predicted.inverse();
  const auto prior = IncrementPrior<double>::of(T_predicted, Vec<double, 6>(0.1 * sigma()));
  testing::Gaussian noise(1);
  const int n = 4000;
  Vec<double, 6> squares = Vec<double, 6>::Zero();
  for (int i = 0; i < n; ++i) {
    const Vec<double, 6> error = 0.1 * sigma().cwiseProduct(noise.vector<6>());
    const Vec<double, 6> r = prior.linearize(plus(T_world_current, error).inverse() * T_world_previous).r;
    squares += r.cwiseProduct(r) / n;
  }
  for (int k = 0; k < 6; ++k) CHECK(squares[k] == Approx(1).epsilon(0.12));
}

TEST_CASE("increment_prior: no weight that is none") {
  CHECK_FALSE(IncrementPrior<double>::of(T_predicted, Vec<double, 6>::Zero()).valid);
  CHECK_FALSE(IncrementPrior<double>::of(T_predicted, Vec<double, 6>::Constant(std::nan(""))).valid);
}
