#include "plumbline/geometry/depth_filter.hpp"

#include <cmath>

#include "catch.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

/// Moments of the posterior by summation over a grid.
struct Moments {
  double mu, variance, f, e;
};
Moments posterior(const DepthFilter<double>& prior, double x, double tau) {
  const int n = 1200;
  const double width = 16 * prior.sigma(), S0 = prior.variance;
  double norm = 0, l1 = 0, l2 = 0, p1 = 0, p2 = 0;
  for (int i = 0; i < n; ++i) {
    const double lambda = prior.mu + width * ((i + 0.5) / n - 0.5);
    const double gauss = std::exp(-(lambda - prior.mu) * (lambda - prior.mu) / (2 * S0));
    const double inlier = std::exp(-(x - lambda) * (x - lambda) / (2 * tau * tau)) / std::sqrt(2 * M_PI * tau * tau);
    for (int k = 0; k < n; ++k) {
      const double pi = (k + 0.5) / n;
      const double beta = std::pow(pi, prior.a - 1) * std::pow(1 - pi, prior.b - 1);
      const double p = gauss * beta * (pi * inlier + (1 - pi) / prior.range);
      norm += p;
      l1 += p * lambda;
      l2 += p * lambda * lambda;
      p1 += p * pi;
      p2 += p * pi * pi;
    }
  }
  return {l1 / norm, l2 / norm - l1 / norm * (l1 / norm), p1 / norm, p2 / norm};
}

}  // namespace

TEST_CASE("depth_filter: mean, variance and inlier share are those of the posterior") {
  for (const double x : {0.5, 0.8, 1.4}) {
    DepthFilter<double> filter = DepthFilter<double>::around(0.6);
    filter.a = 7;
    filter.b = 3;
    filter.variance = 0.01;
    const Moments expected = posterior(filter, x, 0.05);
    filter.update(x, 0.05);
    CAPTURE(x);
    CHECK(filter.mu == Approx(expected.mu).epsilon(1e-4));
    CHECK(filter.variance == Approx(expected.variance).epsilon(1e-3));
    CHECK(filter.inlier_share() == Approx(expected.f).epsilon(1e-4));
    const double n = filter.a + filter.b;
    CHECK(filter.a * (filter.a + 1) / (n * (n + 1)) == Approx(expected.e).epsilon(1e-4));
  }
}

TEMPLATE_TEST_CASE("depth_filter: converges to the value although a third of the measurements are outliers", "", float,
                   double) {
  using S = TestType;
  int converged = 0;
  for (int seed = 0; seed < 50; ++seed) {
    testing::Gaussian noise(std::uint64_t(seed) + 1);
    Random random(std::uint64_t(seed) + 100);
    DepthFilter<S> filter = DepthFilter<S>::around(S(0.5));
    const S truth = S(0.7), tau = S(0.05);
    for (int k = 0; k < 40; ++k) {
      const bool outlier = random.uniform() < 1.0 / 3;
      filter.update(outlier ? S(1.5 * random.uniform()) : truth + tau * S(noise()), tau);
    }
    if (!filter.converged(S(0.1))) continue;
    ++converged;
    CHECK(std::abs(filter.mu - truth) < S(5) * filter.sigma());
    CHECK(filter.sigma() < S(0.03));
  }
  CHECK(converged >= 47);
}

TEST_CASE("depth_filter: never found, or always elsewhere, is rejected") {
  DepthFilter<double> filter = DepthFilter<double>::around(0.5);
  REQUIRE(filter.known());
  REQUIRE_FALSE(DepthFilter<double>{}.known());
  for (int k = 0; k < 40; ++k) filter.miss();
  CHECK(filter.diverged());
  filter = DepthFilter<double>::around(0.5);
  filter.update(std::nan(""), 0.1);
  CHECK(filter.mu == 0.5);
  CHECK(filter.b == 11);
  filter.update(1e6, 1e-9);
  CHECK(std::isfinite(filter.mu));
  CHECK_FALSE(filter.converged(0.1));
}
