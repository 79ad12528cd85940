#include "plumbline/feature/segment_observation.hpp"

#include <Eigen/LU>
#include <limits>
#include <type_traits>

#include "catch.hpp"
#include "feature/seen_lines.hpp"
#include "plumbline/tracking/line_fit.hpp"

using namespace plumbline;
using test::SeenLines;

namespace {

template <class S, bool has_depth, bool rolls>
using Seen = SegmentObservation<S, has_depth, rolls>;

/// An observation with nothing but the segment.
template <class S>
struct Plain {
  bool valid;
  LineSegment segment;
  LineProfile profile;
  SegmentMeasurement<LineReprojection<S>> pixels;
};

// A rig without depth keeps none, one with a global shutter no derivatives.
static_assert(sizeof(Seen<float, false, false>) == sizeof(Plain<float>));
static_assert(sizeof(Seen<double, false, false>) == sizeof(Plain<double>));
static_assert(sizeof(Seen<float, false, true>) > sizeof(Seen<float, false, false>));
static_assert(sizeof(Seen<float, true, false>) >=
              sizeof(Seen<float, false, false>) + sizeof(SegmentMeasurement<LineInverseDepth<float>>));
static_assert(sizeof(Seen<float, true, true>) > sizeof(Seen<float, true, false>));

template <class S>
double whitening_error(const auto& measurement) {
  return double((measurement.L.transpose() * measurement.L * measurement.covariance - Mat<S, 2, 2>::Identity()).norm());
}

}  // namespace

TEST_CASE("segment_observation: the endpoint covariance is that of fits to noisy peaks") {
  testing::Gaussian noise(1);
  constexpr int fits = 20000, peaks = 24;
  Mat<double, 2, 2> sampled = Mat<double, 2, 2>::Zero();
  for (int i = 0; i < fits; ++i) {
    LineMoments<double> moments;
    for (int k = 0; k < peaks; ++k) moments.add(100 * ((k + 0.5) / peaks - 0.5), 0.5 * noise());
    const FittedLine line = moments.line();
    const double derivative = line.direction.y() / line.direction.x(),
                 middle = line.mean.y() - derivative * line.mean.x();
    const Vec<double, 2> ends(middle - 50 * derivative, middle + 50 * derivative);
    sampled += ends * ends.transpose() / fits;
  }
  const Mat<double, 2, 2> expected = endpoint_covariance(0, 0.5f, peaks).cast<double>();
  REQUIRE((sampled - expected).norm() < 0.05 * expected.norm());
  const Mat<float, 2, 2> floor = endpoint_covariance(0.3f, 0.5f, 8) - endpoint_covariance(0, 0.5f, 8);
  REQUIRE((floor - 0.09f * Mat<float, 2, 2>::Identity()).norm() < 1e-6f);
}

TEMPLATE_TEST_CASE("segment_observation: what was measured is whitened by its covariance", "", float, double) {
  using S = TestType;
  const SeenLines<S> scene(1);
  auto seen = scene.store->landmarks()[0].current;
  REQUIRE(whitening_error<S>(seen.pixels) < 1e-4);
  REQUIRE(whitening_error<S>(seen.depth.get()) < 1e-4);
  const Mat<S, 2, 2> L = seen.pixels.L;
  seen.scale_sigma(S(2));
  REQUIRE((seen.pixels.L - L / 2).norm() < S(1e-5));
  REQUIRE(whitening_error<S>(seen.pixels) < 1e-4);
}

TEMPLATE_TEST_CASE("segment_observation: a covariance that is none is no measurement", "", float, double) {
  using S = TestType;
  using Pixels = SegmentMeasurement<LineReprojection<S>>;
  const SeenLines<S> scene(1);
  auto seen = scene.store->landmarks()[0].current;
  const S nan = std::numeric_limits<S>::quiet_NaN();
  for (const Mat<S, 2, 2>& covariance : {Mat<S, 2, 2>(Mat<S, 2, 2>::Constant(nan)),
                                         Mat<S, 2, 2>(-Mat<S, 2, 2>::Identity()), Mat<S, 2, 2>(Mat<S, 2, 2>::Zero())}) {
    const Pixels pixels(seen.pixels.measured, covariance);
    REQUIRE_FALSE(pixels.valid);
    REQUIRE(pixels.L.isZero(0));
    REQUIRE(seen.has_depth());
    auto other = seen;
    other.set_depth(Vec<S, 2>(S(0.5), S(0.5)), covariance);
    REQUIRE_FALSE(other.has_depth());
  }
  REQUIRE_FALSE(Pixels().valid);
}

TEMPLATE_TEST_CASE("segment_observation: depth belongs to the rays through the ends", "", float, double) {
  using S = TestType;
  const SeenLines<S> scene(3);
  for (const auto& landmark : scene.store->landmarks()) {
    auto seen = landmark.current;
    const LineReprojection<S>& pixels = seen.pixels.measured;
    const auto depth = seen.depth.get().measured;
    REQUIRE((depth.m_start - pixels.bearing_start / pixels.bearing_start.z()).norm() < S(1e-6));
    REQUIRE((depth.m_end - pixels.bearing_end / pixels.bearing_end.z()).norm() < S(1e-6));
    seen.clear_depth();
    REQUIRE_FALSE(seen.has_depth());
    seen.pixels.measured.bearing_end.z() = S(-0.1);  // no depth behind the camera
    seen.set_depth(Vec<S, 2>(S(0.5), S(0.5)), Mat<S, 2, 2>::Identity());
    REQUIRE_FALSE(seen.has_depth());
  }
  Seen<S, false, false> without;
  without.pixels = scene.store->landmarks()[0].current.pixels;
  without.set_depth(Vec<S, 2>(S(0.5), S(0.5)), Mat<S, 2, 2>::Identity());
  REQUIRE_FALSE(without.has_depth());
}

TEMPLATE_TEST_CASE("segment_observation: bearings and rays turn with the readout, the image's segment does not", "",
                   float, double) {
  using S = TestType;
  const SeenLines<S> scene(4);
  for (const auto& landmark : scene.store->landmarks()) {
    const S step = S(1e-3);
    const auto& before = landmark.current;
    auto after = before;
    after.change_readout(step);
    const auto &x = before.pixels.measured, &y = after.pixels.measured;
    const Mat<S, 3, 2> derivative = before.by_readout();
    REQUIRE((y.bearing_start - x.bearing_start - step * derivative.col(0)).norm() < S(2e-6));
    REQUIRE((y.bearing_end - x.bearing_end - step * derivative.col(1)).norm() < S(2e-6));
    REQUIRE(y.bearing_start.norm() == Approx(1));
    const auto depth = after.depth.get().measured;
    REQUIRE((depth.m_start - y.bearing_start / y.bearing_start.z()).norm() < S(1e-6));
    REQUIRE(depth.inverse_depth_measured == before.depth.get().measured.inverse_depth_measured);
    REQUIRE(after.place().start == before.segment.start);

    auto unseen = before;
    unseen.valid = false;
    unseen.change_readout(step);
    REQUIRE(unseen.pixels.measured.bearing_start == x.bearing_start);
  }
  Seen<S, true, false> still;
  still.valid = true;
  still.pixels.measured.bearing_start = still.pixels.measured.bearing_end = Vec<S, 3>::UnitZ();
  still.change_readout(S(1));
  REQUIRE(still.pixels.measured.bearing_start == Vec<S, 3>::UnitZ());
}
