#include "plumbline/feature/line_geometry.hpp"

#include <cmath>
#include <limits>
#include <type_traits>

#include "catch.hpp"
#include "feature/seen_lines.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;
using test::SeenLines;

static_assert(sizeof(LineGeometry<float>) <= sizeof(Line3<float>) + 18 * sizeof(float) + 16);

TEST_CASE("line_geometry: the extent follows what another camera sees of the line") {
  const SeenLines<double> scene(12);
  for (std::size_t i = 0; i < 12; ++i) {
    LineGeometry<double> line = scene.store->landmarks()[i].geometry;
    const int anchor = scene.store->landmarks()[i].anchor;
    const SE3<double> T_cam_anchor = scene.T_world_cam(3).inverse() * scene.T_world_cam(anchor);
    const Vec<double, 3> p = scene.T_world_cam(3).inverse() * scene.p_world[i],
                         q = scene.T_world_cam(3).inverse() * scene.q_world[i], third = p + (q - p) / 3;
    line.set_extent(T_cam_anchor, p.normalized(), third.normalized());
    REQUIRE((T_cam_anchor * line.at(line.extent[0]) - p).norm() < 1e-9);
    REQUIRE((T_cam_anchor * line.at(line.extent[1]) - third).norm() < 1e-9);
    REQUIRE((T_cam_anchor * line.middle() - (p + third) / 2).norm() < 1e-9);
    const Vec<double, 2> before = line.extent;
    line.set_extent(T_cam_anchor, -p, Vec<double, 3>::Constant(std::numeric_limits<double>::quiet_NaN()));
    REQUIRE(line.extent == before);
  }
}

TEMPLATE_TEST_CASE("line_geometry: the line rotates with the bearings of its anchor, by the given derivative", "",
                   float, double) {
  using S = TestType;
  const SeenLines<S> scene(12, 0);
  for (const auto& landmark : scene.store->landmarks()) {
    const S step = std::is_same_v<S, float> ? S(1e-2) : S(1e-4);
    const LineGeometry<S>& line = landmark.geometry;
    const auto& seen = landmark.seen_by_anchor();
    Vec<S, 6> derivative = line.derivative(seen.pixels.measured, seen.by_readout());
    auto longer = line, shorter = line;
    longer.change(Vec<S, 6>(step * derivative));
    shorter.change(Vec<S, 6>(-step * derivative));
    const auto normalized = [](const Line3<S>& x) {
      const Plucker<S> plucker = x.plucker();
      Vec<S, 6> out;
      out << plucker.n, plucker.v;
      return out;
    };
    // Only the line counts, not the scale of its coordinates: compare what has length one.
    const Vec<S, 6> x = normalized(line.line);
    derivative -= x * x.dot(derivative);
    const Vec<S, 6> numeric = (normalized(longer.line) - normalized(shorter.line)) / (2 * step);
    REQUIRE((numeric - derivative).norm() < S(std::is_same_v<S, float> ? 1e-3 : 1e-7));
    // Without noise the anchor's endpoints stay on the line.
    auto turned = seen;
    turned.change_readout(step);
    REQUIRE(turned.pixels.measured.residual(longer.line.plucker()).norm() < S(std::is_same_v<S, float> ? 2e-2 : 1e-4));
  }
}

TEST_CASE("line_geometry: a line that its anchor does not see has no derivative") {
  const SeenLines<double> scene(1);
  const auto& landmark = scene.store->landmarks()[0];
  LineReprojection<double> behind = landmark.seen_by_anchor().pixels.measured;
  behind.bearing_start *= -1;
  behind.bearing_end *= -1;
  REQUIRE(landmark.geometry.derivative(behind, landmark.seen_by_anchor().by_readout()).isZero(0));
  LineReprojection<double> point = landmark.seen_by_anchor().pixels.measured;
  point.bearing_end = point.bearing_start;
  REQUIRE(landmark.geometry.derivative(point, landmark.seen_by_anchor().by_readout()).isZero(0));
}

TEST_CASE("line_geometry: a line is sound while its distance is known and its anchor sees it") {
  const SeenLines<double> scene(1);
  const LineReprojection<double> seen = scene.store->landmarks()[0].seen_by_anchor().pixels.measured;
  LineGeometry<double> known = scene.store->landmarks()[0].geometry;
  known.covariance = 1e-6 * Mat<double, 4, 4>::Identity();
  REQUIRE(known.is_sound(seen));
  LineGeometry<double> other = known;
  other.covariance *= 1e6;
  REQUIRE_FALSE(other.is_sound(seen));
  other = known;
  other.covariance(1, 2) = std::numeric_limits<double>::quiet_NaN();
  REQUIRE_FALSE(other.is_sound(seen));
  other = known;
  const Plucker<double> line = other.line.plucker();
  other.line = Line3<double>(Plucker<double>{1e-3 * line.n, line.v});
  REQUIRE_FALSE(other.is_sound(seen));
  other.line = Line3<double>(Plucker<double>{-line.n, line.v});  // behind the camera
  REQUIRE_FALSE(other.is_sound(seen));
}

TEST_CASE("line_geometry: another unit of length") {
  const SeenLines<double> scene(12);
  for (const auto& landmark : scene.store->landmarks()) {
    const double scale = 1.7;
    const LineGeometry<double>& original = landmark.geometry;
    LineGeometry<double> line = original;
    line.covariance.setIdentity();
    line.rescale(scale);
    for (const int i : {0, 1}) {
      REQUIRE((line.at(line.extent[i]) - scale * original.at(original.extent[i])).norm() < 1e-9);
    }
    const auto scaled = [&](const Line3<double>& before) -> Vec<double, 4> {
      const Plucker<double> x = before.plucker();
      return minus(Line3<double>(Plucker<double>{scale * x.n, x.v}), line.line);
    };
    const Mat<double, 4, 4> J = testing::numeric_jacobian<4, 4>(scaled, original.line, 1e-5);
    REQUIRE((line.covariance - J * J.transpose()).norm() < 1e-8);
  }
}
