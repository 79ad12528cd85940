#include "plumbline/geometry/line_depth.hpp"

#include <limits>
#include <vector>

#include <Eigen/LU>

#include "catch.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;

namespace {

struct Noise {
  Random random;
  double operator()(double sigma) {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += random.uniform();
    return sigma * sum;
  }
};

template <class S>
std::vector<LineDepthSample<S>> samples_of(double l_a, double l_b, int n, double sigma, Noise& noise) {
  std::vector<LineDepthSample<S>> out;
  for (int k = 0; k < n; ++k) {
    const double s = (k + 0.5) / n;
    out.push_back({S(s), S((1 - s) * l_a + s * l_b + noise(sigma)), S(sigma)});
  }
  return out;
}

template <class S>
LineDepth<S> fit(const std::vector<LineDepthSample<S>>& samples, const LineDepthOptions& options = {}) {
  return fit_line_depth(std::span<const LineDepthSample<S>>(samples), options);
}

}  // namespace

TEST_CASE("line_depth: inverse depth is affine along a segment on the plane z = 1") {
  const Vec<double, 3> p(-0.4, -0.3, 1.2), q(0.9, 0.2, 3.8);
  const Vec<double, 3> m_p = p / p.z(), m_q = q / q.z();
  for (double t = 0; t <= 1; t += 0.1) {
    const Vec<double, 3> X = p + t * (q - p), m = X / X.z();
    const double s = along_segment(m, m_p, m_q);
    REQUIRE((1 - s) / p.z() + s / q.z() == Approx(1 / X.z()));
  }
  const Line3<double> line = line_from_depth(m_p, m_q, Vec<double, 2>(1 / p.z(), 1 / q.z()));
  REQUIRE((line.plucker().point_along(p) - p).norm() < 1e-12);
  REQUIRE((line.direction() - (q - p).normalized()).norm() < 1e-12);
}

TEMPLATE_TEST_CASE("line_depth: the noise of the result is the predicted one", "", float, double) {
  using S = TestType;
  Noise noise{Random(1)};
  const Vec<double, 2> truth(0.5, 0.3);
  LineDepthOptions options;
  options.independent_samples = 1000;  // here they are
  double mahalanobis = 0;
  int n = 0;
  for (; n < 500; ++n) {
    const LineDepth<S> found = fit(samples_of<S>(truth[0], truth[1], 30, 3e-3, noise), options);
    REQUIRE(found.valid);
    REQUIRE(found.inliers >= 26);
    const Vec<double, 2> d = found.inverse_depth.template cast<double>() - truth;
    mahalanobis += d.dot(found.covariance.template cast<double>().inverse() * d);
  }
  REQUIRE(mahalanobis / n == Approx(2).epsilon(0.2));
  // correlated samples: eight count, however many there are
  const auto trace = [&](int samples) {
    return fit(samples_of<S>(truth[0], truth[1], samples, 3e-3, noise)).covariance.trace();
  };
  REQUIRE(trace(60) == Approx(trace(30)).epsilon(0.15));
}

TEMPLATE_TEST_CASE("line_depth: a surface seen beside the segment is followed up to it", "", float, double) {
  using S = TestType;
  Noise noise{Random(4)};
  const Vec<double, 3> normal = Vec<double, 3>(0.6, -0.1, -0.8), m_start(-0.2, -0.3, 1), m_end(-0.1, 0.4, 1);
  const auto inverse_depth = [&](const Vec<double, 3>& m) { return normal.dot(m) / -1.6; };
  const Vec<double, 2> truth(inverse_depth(m_start), inverse_depth(m_end));
  LineDepthOptions options;
  options.independent_samples = 1000;  // here they are
  double mahalanobis = 0, beside = 0;
  Vec<double, 2> mean = Vec<double, 2>::Zero();
  constexpr int n = 500;
  for (int i = 0; i < n; ++i) {
    std::vector<LineDepthSample<S>> samples;
    for (int k = 0; k < 60; ++k) {
      const Vec<double, 3> m = m_start + (k + 0.5) / 60 * (m_end - m_start) + Vec<double, 3>(k % 2 ? 0.03 : 0.01, 0, 0);
      const Vec<S, 3> ray = m.cast<S>(), from = m_start.cast<S>(), to = m_end.cast<S>();
      const double l = inverse_depth(m);
      beside += l / (60 * n);
      samples.push_back({along_segment(ray, from, to), S(l + noise(3e-3)), S(3e-3), across_segment(ray, from, to)});
    }
    const LineDepth<S> found = fit(samples, options);
    REQUIRE(found.valid);
    const Vec<double, 2> d = found.inverse_depth.template cast<double>() - truth;
    mean += d / n;
    mahalanobis += d.dot(found.covariance.template cast<double>().inverse() * d) / n;
  }
  REQUIRE(beside - truth.mean() < -5e-3);  // what was measured is off by this
  REQUIRE(std::abs(mean[0]) < 2e-4);
  REQUIRE(std::abs(mean[1]) < 2e-4);
  REQUIRE(mahalanobis == Approx(2).epsilon(0.2));
}

TEMPLATE_TEST_CASE("line_depth: the nearer side of an occluding edge, and outliers", "", float, double) {
  using S = TestType;
  Noise noise{Random(2)};
  const double sigma = 7e-3;  // as structured light at 3 m
  int together = 0, taken_for_one = 0;
  double ledge_error = 0;
  for (int i = 0; i < 200; ++i) {
    const auto near = samples_of<S>(0.5, 0.45, 24, sigma, noise), far = samples_of<S>(0.2, 0.22, 24, sigma, noise),
               same = samples_of<S>(0.5, 0.45, 24, sigma, noise);
    std::vector<LineDepthSample<S>> broken = near;  // one in three has lost the near side
    for (std::size_t k = 1; k < broken.size(); k += 3) broken[k] = far[k];
    const LineDepth<S> one = fit(near), edge = nearer_side(one, fit(far)), texture = nearer_side(one, fit(same));
    for (const LineDepth<S>& found : {edge, nearer_side(fit(far), one), texture, fit(broken)}) {
      REQUIRE(found.valid);
      REQUIRE(found.inverse_depth[0] == Approx(0.5).margin(2e-2));
      REQUIRE(found.inverse_depth[1] == Approx(0.45).margin(2e-2));
    }
    REQUIRE(edge.inverse_depth == one.inverse_depth);
    REQUIRE(edge.covariance == one.covariance);
    REQUIRE(fit(broken).inliers <= 17);
    if (texture.inliers > one.inliers + 10) {
      ++together;
      REQUIRE(texture.covariance(0, 0) == Approx(one.covariance(0, 0) / 2).epsilon(0.3));
    }
    // 3.0 m before 3.2 m: three sigma of one sample's difference would be 0.26 m
    const LineDepth<S> ledge = nearer_side(fit(samples_of<S>(1 / 3.0, 1 / 3.0, 24, sigma, noise)),
                                           fit(samples_of<S>(1 / 3.2, 1 / 3.2, 24, sigma, noise)));
    taken_for_one += ledge.inliers > 24;
    ledge_error += 3 - 2 / double(ledge.inverse_depth.sum());
  }
  REQUIRE(together >
          0.7 * 200);  // samples add up to eight only, so these are better than their covariance: 1 - exp(-3/2)
  REQUIRE(taken_for_one < 0.1 * 200);
  REQUIRE(std::abs(ledge_error / 200) < 0.02);
  // what has one side only has that
  const LineDepth<S> alone = fit(samples_of<S>(0.5, 0.45, 24, sigma, noise));
  REQUIRE(nearer_side(alone, LineDepth<S>{}).inverse_depth == alone.inverse_depth);
  REQUIRE(nearer_side(LineDepth<S>{}, alone).inverse_depth == alone.inverse_depth);
  REQUIRE_FALSE(nearer_side(LineDepth<S>{}, LineDepth<S>{}).valid);
}

TEMPLATE_TEST_CASE("line_depth: not valid without agreement, extent, certainty or samples", "", float, double) {
  using S = TestType;
  Noise noise{Random(3)};
  std::vector<LineDepthSample<S>> scattered = samples_of<S>(0.5, 0.45, 24, 3e-3, noise);
  for (std::size_t k = 0; k < scattered.size(); k += 2) scattered[k].inverse_depth = S(0.1 + noise.random.uniform());
  REQUIRE_FALSE(fit(scattered).valid);
  auto one_end = samples_of<S>(0.5, 0.45, 40, 3e-3, noise);
  one_end.resize(14);  // the first third
  REQUIRE_FALSE(fit(one_end).valid);
  REQUIRE_FALSE(fit(samples_of<S>(0.05, 0.04, 24, 1e-2, noise)).valid);  // 20 m
  REQUIRE_FALSE(fit(samples_of<S>(-0.5, -0.4, 24, 3e-3, noise)).valid);
  REQUIRE_FALSE(fit(samples_of<S>(0.5, 0.4, 2, 3e-3, noise)).valid);
  REQUIRE_FALSE(fit<S>({}).valid);
  auto nan = samples_of<S>(0.5, 0.45, 24, 3e-3, noise);
  for (auto& x : nan) x.inverse_depth = std::numeric_limits<S>::quiet_NaN();
  REQUIRE_FALSE(fit(nan).valid);
}
