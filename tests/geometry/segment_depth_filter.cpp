#include "plumbline/geometry/segment_depth_filter.hpp"

#include <cmath>
#include <limits>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

constexpr double sigma_rad = 1e-3;

/// A segment in space before cameras that move aside.
template <class S>
struct Scene {
  Vec<double, 3> p, q;
  testing::Gaussian noise;
  double scale;  ///< of the noise

  Scene(std::uint64_t seed, double noise_scale) : noise(seed + 1), scale(noise_scale) {
    Random random(seed);
    const auto within = [&](double a, double b) { return a + (b - a) * random.uniform(); };
    const double angle = within(-0.6, 0.6);  // from the vertical: across the motion
    const Vec<double, 3> middle(within(-0.5, 0.5), within(-0.5, 0.5), within(2, 4));
    const Vec<double, 3> half(0.4 * std::sin(angle), 0.4 * std::cos(angle), within(-0.2, 0.2));
    p = middle - half, q = middle + half;
  }
  static SE3<double> T_seen_anchor(int k) {
    return SE3<double>(SO3<double>::exp(Vec<double, 3>(0.002, -0.004, 0.003) * k),
                       Vec<double, 3>(-0.02, 0.003, 0.004) * k);
  }
  /// What a camera measures: other parts of the line each time, both ends off across it.
  SegmentRays<S> rays(const SE3<double>& T, double from = 0, double to = 1) {
    const Vec<double, 3> a = T * (p + from * (q - p)), b = T * (p + to * (q - p)), across = a.cross(b).normalized();
    SegmentRays<S> out;
    out.start = (a.normalized() + scale * sigma_rad * noise() * across).normalized().template cast<S>();
    out.end = (b.normalized() + scale * sigma_rad * noise() * across).normalized().template cast<S>();
    out.C = S(sigma_rad * sigma_rad) * Mat<S, 2, 2>::Identity();
    return out;
  }
  double inverse_range(int i) const { return 1 / (i == 0 ? p : q).norm(); }
};

}  // namespace

TEMPLATE_TEST_CASE("segment_depth_filter: without noise both ends are where they are", "", float, double) {
  using S = TestType;
  for (int seed = 0; seed < 20; ++seed) {
    Scene<S> scene(std::uint64_t(seed), 0);
    const SegmentRays<S> anchor = scene.rays({});
    auto filter = SegmentDepthFilter<S>::around(S(0.4));
    REQUIRE(filter.known());
    REQUIRE_FALSE(SegmentDepthFilter<S>{}.known());
    for (int k = 1; k <= 30; ++k) {
      const SE3<double> T = Scene<S>::T_seen_anchor(k);
      filter.update(anchor, scene.rays(T, 0.1, 0.8), T.template cast<S>());
    }
    CHECK(filter.converged(S(0.1), anchor));
    for (int i = 0; i < 2; ++i) {
      CHECK(double(filter.ends()[std::size_t(i)].depth.mu) == Approx(scene.inverse_range(i)).epsilon(0.005));
    }
  }
}

TEST_CASE("segment_depth_filter: beta is what the anchor's ray does to the mean") {
  // Small steps of one ray, the measurements as they are: only exact to first order, and the weights are held.
  Scene<double> scene(4, 0);
  const SegmentRays<double> anchor = scene.rays({});
  const auto mean = [&](double delta) {
    SegmentRays<double> moved = anchor;
    const Vec<double, 3> m_a = anchor.start.cross(anchor.end).normalized();
    moved.start = (anchor.start + delta * m_a).normalized();
    auto filter = SegmentDepthFilter<double>::around(0.4);
    for (int k = 1; k <= 25; ++k) {
      const SE3<double> T = Scene<double>::T_seen_anchor(k);
      filter.update(moved, scene.rays(T), T);
    }
    return filter.ends()[0];
  };
  const double step = 1e-6, numeric = (mean(step).depth.mu - mean(-step).depth.mu) / (2 * step);
  CHECK(mean(0).by_anchor == Approx(numeric).epsilon(0.05));
}

TEST_CASE("segment_depth_filter: errors are consistent with its variance") {
  double squares = 0, own = 0;
  int count = 0, converged = 0;
  for (int seed = 0; seed < 400; ++seed) {
    Scene<double> scene(std::uint64_t(seed), 1);
    const SegmentRays<double> anchor = scene.rays({});
    auto filter = SegmentDepthFilter<double>::around(0.4);
    for (int k = 1; k <= 30; ++k) {
      const SE3<double> T = Scene<double>::T_seen_anchor(k);
      filter.update(anchor, scene.rays(T, 0.05, 0.9), T);
    }
    converged += filter.converged(0.1, anchor);
    for (int i = 0; i < 2; ++i) {
      const auto& depth = filter.ends()[std::size_t(i)].depth;
      const double error = depth.mu - scene.inverse_range(i);
      squares += error * error / filter.variance(i, anchor);
      own += error * error / depth.variance;
      ++count;
    }
  }
  CAPTURE(squares / count, own / count, converged);
  CHECK(converged > 380);
  CHECK(squares / count > 0.6);
  CHECK(squares / count < 1.3);
  CHECK(own / count > 2);  // the anchor's error does not average out
}

TEST_CASE("segment_depth_filter: a baseline in the plane of the line, or none, gives no update") {
  Scene<double> scene(1, 1);
  const SegmentRays<double> anchor = scene.rays({});
  auto filter = SegmentDepthFilter<double>::around(0.4);
  const auto is_as_it_was = [&] {
    const auto& ends = filter.ends();
    const auto fresh = DepthFilter<double>::around(0.4);
    return ends[0].depth.mu == fresh.mu && ends[1].depth.variance == fresh.variance && ends[0].by_anchor == 0;
  };
  for (const Vec<double, 3>& t :
       {Vec<double, 3>(0, 0, 0), Vec<double, 3>(0.5 * (scene.q - scene.p)), Vec<double, 3>(0.2 * scene.p)}) {
    const SE3<double> T(SO3<double>(), t);
    filter.update(anchor, scene.rays(T), T);
    CHECK(is_as_it_was());
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const SE3<double> T = Scene<double>::T_seen_anchor(5);
  SegmentRays<double> seen = scene.rays(T);
  seen.start[1] = nan;
  filter.update(anchor, seen, T);
  CHECK(is_as_it_was());
  seen = scene.rays(T);
  filter.update(anchor, seen, SE3<double>(T.rotation(), Vec<double, 3>(nan, 0, 0)));
  CHECK(is_as_it_was());
  seen.end = seen.start;
  filter.update(anchor, seen, T);
  CHECK(is_as_it_was());
}

TEST_CASE("segment_depth_filter: edges of another line are rejected") {
  Scene<double> scene(2, 1), other(3, 1);
  other.p = scene.p, other.q = scene.q;
  Random random(5);
  const SegmentRays<double> anchor = scene.rays({});
  auto filter = SegmentDepthFilter<double>::around(0.4);
  for (int k = 10; k < 60; ++k) {
    const Vec<double, 3> aside(4 * random.uniform() - 2, 0, 0);
    other.p = scene.p + aside, other.q = scene.q + aside;
    const SE3<double> T = Scene<double>::T_seen_anchor(k);
    filter.update(anchor, other.rays(T), T);
  }
  CHECK_FALSE(filter.converged(0.33, anchor));
}
