#include "plumbline/feature/line_landmark.hpp"

#include <cmath>
#include <limits>

#include <Eigen/LU>

#include "catch.hpp"
#include "feature/seen_lines.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"
#include "plumbline/tracking/line_fit.hpp"

using namespace plumbline;
using test::SeenLines;

TEST_CASE("line_landmark: the endpoint covariance is that of fits to noisy peaks") {
  testing::Gaussian noise(1);
  constexpr int fits = 20000, peaks = 24;
  Mat<double, 2, 2> sampled = Mat<double, 2, 2>::Zero();
  for (int i = 0; i < fits; ++i) {
    LineMoments<double> moments;
    for (int k = 0; k < peaks; ++k) moments.add(100 * ((k + 0.5) / peaks - 0.5), 0.5 * noise());
    const FittedLine line = moments.line();
    const double slope = line.direction.y() / line.direction.x(), middle = line.mean.y() - slope * line.mean.x();
    const Vec<double, 2> ends(middle - 50 * slope, middle + 50 * slope);
    sampled += ends * ends.transpose() / fits;
  }
  const Mat<double, 2, 2> expected = endpoint_covariance(0, 0.5f, peaks).cast<double>();
  REQUIRE((sampled - expected).norm() < 0.05 * expected.norm());
  const Mat<float, 2, 2> floor = endpoint_covariance(0.3f, 0.5f, 8) - endpoint_covariance(0, 0.5f, 8);
  REQUIRE((floor - 0.09f * Mat<float, 2, 2>::Identity()).norm() < 1e-6f);
}

TEMPLATE_TEST_CASE("line_landmark: observations are whitened by their covariances", "", float, double) {
  using S = TestType;
  const SeenLines<S> scene(1);
  SegmentObservation<S> seen = scene.map->landmarks()[0].current;
  REQUIRE((seen.pixels_L.transpose() * seen.pixels_L * seen.pixels_covariance - Mat<S, 2, 2>::Identity()).norm() <
          S(1e-4));
  REQUIRE((seen.depth_L.transpose() * seen.depth_L * seen.depth_covariance - Mat<S, 2, 2>::Identity()).norm() <
          S(1e-4));
  const Mat<S, 2, 2> L = seen.pixels_L;
  seen.scale_sigma(S(2));
  REQUIRE((seen.pixels_L - L / 2).norm() < S(1e-5));
  REQUIRE((seen.pixels_L.transpose() * seen.pixels_L * seen.pixels_covariance - Mat<S, 2, 2>::Identity()).norm() <
          S(1e-4));

  const S nan = std::numeric_limits<S>::quiet_NaN();
  REQUIRE_FALSE(seen.set_pixels(seen.pixels, Mat<S, 2, 2>::Constant(nan)));
  REQUIRE_FALSE(seen.set_pixels(seen.pixels, -Mat<S, 2, 2>::Identity()));
  REQUIRE(seen.pixels_L.allFinite());
  seen.set_depth(Vec<S, 2>(S(0.5), S(0.5)), Mat<S, 2, 2>::Constant(nan));
  REQUIRE_FALSE(seen.has_depth);
}

TEST_CASE("line_landmark: the extent follows what another camera sees of the line") {
  const SeenLines<double> scene(12);
  for (std::size_t i = 0; i < 12; ++i) {
    auto landmark = scene.map->landmarks()[i];
    const SE3<double> T_cam_anchor = scene.T_world_cam(3).inverse() * scene.T_world_cam(landmark.anchor);
    const Vec<double, 3> p = scene.T_world_cam(3).inverse() * scene.p_world[i],
                         q = scene.T_world_cam(3).inverse() * scene.q_world[i], third = p + (q - p) / 3;
    landmark.set_extent(T_cam_anchor, p.normalized(), third.normalized());
    REQUIRE((T_cam_anchor * landmark.at(landmark.extent[0]) - p).norm() < 1e-9);
    REQUIRE((T_cam_anchor * landmark.at(landmark.extent[1]) - third).norm() < 1e-9);
    REQUIRE((T_cam_anchor * landmark.middle() - (p + third) / 2).norm() < 1e-9);
    const Vec<double, 2> before = landmark.extent;
    landmark.set_extent(T_cam_anchor, -p, Vec<double, 3>::Constant(std::numeric_limits<double>::quiet_NaN()));
    REQUIRE(landmark.extent == before);
  }
}

TEMPLATE_TEST_CASE("line_landmark: line and bearings turn with the readout, by the slope that is told", "", float,
                   double) {
  using S = TestType;
  const SeenLines<S> scene(12, 0);
  for (const auto& landmark : scene.map->landmarks()) {
    const S step = std::is_same_v<S, float> ? S(1e-2) : S(1e-4);
    auto longer = landmark, shorter = landmark;
    longer.change_readout(step);
    shorter.change_readout(-step);
    const auto normalized = [](const Line3<S>& line) {
      const Plucker<S> x = line.plucker();
      Vec<S, 6> out;
      out << x.n, x.v;
      return out;
    };
    // Only the line counts, not the scale of its coordinates: compare what has length one.
    Vec<S, 6> slope = landmark.line_slope(), x = normalized(landmark.line);
    slope -= x * x.dot(slope);
    const Vec<S, 6> numeric = (normalized(longer.line) - normalized(shorter.line)) / (2 * step);
    REQUIRE((numeric - slope).norm() < S(std::is_same_v<S, float> ? 1e-3 : 1e-7));
    // Without noise the anchor's endpoints stay on the line.
    const auto& seen = longer.seen_by_anchor();
    REQUIRE(seen.pixels.residual(longer.line.plucker()).norm() < S(std::is_same_v<S, float> ? 2e-2 : 1e-4));
    REQUIRE((seen.depth.m_start - seen.pixels.bearing_start / seen.pixels.bearing_start.z()).norm() < S(1e-6));
    REQUIRE((longer.current.pixels.bearing_start - landmark.current.pixels.bearing_start -
             step * landmark.current.bearing_slope.col(0))
                .norm() < S(1e-4));
  }
}

TEST_CASE("line_landmark: a line is sound while its distance is known and its anchor sees it") {
  const SeenLines<double> scene(1);
  auto landmark = scene.map->landmarks()[0];
  landmark.covariance = 1e-6 * Mat<double, 4, 4>::Identity();
  REQUIRE(landmark.is_sound());
  auto other = landmark;
  other.covariance *= 1e6;
  REQUIRE_FALSE(other.is_sound());
  other = landmark;
  other.covariance(1, 2) = std::numeric_limits<double>::quiet_NaN();
  REQUIRE_FALSE(other.is_sound());
  other = landmark;
  other.observations[std::size_t(other.anchor)].valid = false;
  REQUIRE_FALSE(other.is_sound());
  other = landmark;
  const Plucker<double> line = other.line.plucker();
  other.line = Line3<double>(Plucker<double>{1e-3 * line.n, line.v});
  REQUIRE_FALSE(other.is_sound());
  other.line = Line3<double>(Plucker<double>{-line.n, line.v});  // behind the camera
  REQUIRE_FALSE(other.is_sound());
}

TEST_CASE("line_landmark: another unit of length") {
  const SeenLines<double> scene(12);
  for (const auto& original : scene.map->landmarks()) {
    const double scale = 1.7;
    auto landmark = original;
    landmark.covariance.setIdentity();
    landmark.rescale(scale);
    for (const int i : {0, 1}) {
      REQUIRE((landmark.at(landmark.extent[i]) - scale * original.at(original.extent[i])).norm() < 1e-9);
    }
    const auto scaled = [&](const Line3<double>& line) -> Vec<double, 4> {
      const Plucker<double> x = line.plucker();
      return minus(Line3<double>(Plucker<double>{scale * x.n, x.v}), landmark.line);
    };
    const Mat<double, 4, 4> J = testing::numeric_jacobian<4, 4>(scaled, original.line, 1e-5);
    REQUIRE((landmark.covariance - J * J.transpose()).norm() < 1e-8);
  }
}
