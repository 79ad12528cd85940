#include "plumbline/frontend/segment_measurement.hpp"

#include <limits>
#include <memory>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/camera/radtan.hpp"
#include "plumbline/sensor/mono.hpp"

using namespace plumbline;

namespace {

constexpr int width = 320, height = 240;

template <class S, class Shutter = Global>
struct Frame {
  using Camera = Pinhole<S, RadTan>;
  using Sensors = Rig<Mono<Camera, width * height, Shutter>>;
  using Observation = SegmentObservation<S, false, Sensors::rolls>;

  Sensors rig{};
  std::unique_ptr<RigPyramid<Sensors>> pyramid = std::make_unique<RigPyramid<Sensors>>();
  S readout_s;
  Vec<S, 3> rate = zeros<S, 3>(), velocity = zeros<S, 3>();

  explicit Frame(S readout = 0) : readout_s(readout) {
    rig.vision.camera = {S(200), S(200), S(159.5), S(119.5), {S(-0.28), S(0.07), S(0), S(0)}};
  }
  auto shutter() const {
    typename Sensors::Shutter::template Model<Camera> out(rig.vision.camera, height, readout_s);
    out.set_motion(rate, velocity, S(0.5));
    return out;
  }
  void measure(const LineSegment& segment, const Mat<float, 2, 2>& covariance, Observation& out) const {
    const View<Sensors> view{0, S(0), rig, *pyramid, *pyramid, {}, {}, {}, shutter()};
    measure_segment(view, segment, covariance, out);
  }
  Vec<S, 3> bearing(const Vec<S, 2>& uv) const { return rig.vision.camera.unproject(uv).bearing; }
};

const LineSegment edge{{60, 40}, {250, 200}, 20};
Mat<float, 2, 2> correlated() {
  Mat<float, 2, 2> C;
  C << 0.5f, -0.1f, -0.1f, 0.25f;
  return C;
}
template <class S>
constexpr S tolerance = std::is_same_v<S, float> ? S(2e-5) : S(1e-10);

}  // namespace

TEMPLATE_TEST_CASE("segment_measurement: rays through the ends, whitened by the covariance across", "", float, double) {
  using S = TestType;
  const Frame<S> frame;
  typename Frame<S>::Observation seen;
  frame.measure(edge, correlated(), seen);
  REQUIRE((seen.valid && seen.pixels.valid));
  CHECK(seen.segment.start == edge.start);
  CHECK(seen.segment.end == edge.end);
  CHECK(norm(Vec<S, 3>(seen.pixels.measured.bearing_start - frame.bearing({60, 40}))) < tolerance<S>);
  CHECK(norm(Vec<S, 3>(seen.pixels.measured.bearing_end - frame.bearing({250, 200}))) < tolerance<S>);
  const Mat<S, 2, 2> C = cast_to<S>(correlated());
  CHECK(seen.pixels.covariance == C);
  CHECK((seen.pixels.L.transpose() * seen.pixels.L * C - identity<S, 2>()).norm() < S(1e-5));
}

TEMPLATE_TEST_CASE("segment_measurement: not valid without two rays or without a covariance, and nothing is taken", "",
                   float, double) {
  using S = TestType;
  const Frame<S> frame;
  typename Frame<S>::Observation before;
  frame.measure(edge, correlated(), before);
  REQUIRE(before.valid);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto refuses = [&](const LineSegment& other, const Mat<float, 2, 2>& covariance) {
    auto seen = before;
    frame.measure(other, covariance, seen);
    return !seen.valid && seen.segment.start == edge.start && seen.pixels.valid && seen.pixels.L == before.pixels.L;
  };
  CHECK(refuses({{60, 40}, {60, 40}, 20}, correlated()));
  CHECK(refuses({{nan, 40}, {250, 200}, 20}, correlated()));
  CHECK(refuses({{60, 40}, {250, nan}, 20}, correlated()));
  CHECK(refuses({{60, 41}, {250, 201}, 20}, Mat<float, 2, 2>(-correlated())));
  CHECK(refuses({{60, 41}, {250, 201}, 20}, Mat<float, 2, 2>(Mat<float, 2, 2>::Constant(nan))));
}

TEMPLATE_TEST_CASE("segment_measurement: rays are those of the middle of the frame, by the ranges of the frame before",
                   "", float, double) {
  using S = TestType;
  Frame<S, Rolling> frame(S(0.03));
  frame.rate = Vec<S, 3>(0, S(1), S(0.5));
  frame.velocity = Vec<S, 3>(2, 0, 0);
  typename Frame<S, Rolling>::Observation seen;
  auto ranges = seen.derivatives.get();
  ranges[0].inverse_range = S(0.25);  // of the end there is none: that of the scene
  seen.derivatives.set(ranges);
  frame.measure(edge, correlated(), seen);
  REQUIRE(seen.valid);
  CHECK(seen.segment.start == edge.start);  // as it is in the image
  const auto shutter = frame.shutter();
  const Vec<S, 3> start = frame.bearing(shutter.still({60, 40}, S(0.25)).uv),
                  end = frame.bearing(shutter.still({250, 200}, S(0.5)).uv);
  CHECK(norm(Vec<S, 3>(seen.pixels.measured.bearing_start - start)) < tolerance<S>);
  CHECK(norm(Vec<S, 3>(seen.pixels.measured.bearing_end - end)) < tolerance<S>);
  CHECK(norm(Vec<S, 3>(start - frame.bearing({60, 40}))) > S(1e-3));
  const auto& derivatives = seen.derivatives.get();
  CHECK(derivatives[0].inverse_range == S(0.25));
  CHECK(derivatives[1].inverse_range == S(0.5));
  const Vec<S, 3> expected = shutter.bearing_derivative({60, 40}, start, S(0.25)).by_readout();
  CHECK(norm(Vec<S, 3>(derivatives[0].by_readout() - expected)) < S(10) * tolerance<S>);
  CHECK(norm(expected) > S(0.1));
}
