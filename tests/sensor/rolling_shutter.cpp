#include "plumbline/sensor/rolling_shutter.hpp"

#include <cmath>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/camera/radtan.hpp"
#include "plumbline/testing/gaussian.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;

namespace {
template <class S>
Pinhole<S, RadTan> camera() {
  return {S(517), S(516), S(319), S(255), {S(0.26), S(-0.95), S(-0.005), S(0.003), S(1.16)}};
}
constexpr int height = 480;

/// How a camera moves that sees things in a distance of `range`.
template <class S>
struct Motion {
  Vec<S, 3> w, v = Vec<S, 3>::Zero();
  S range = S(2);
};

template <class S>
RollingShutter<Pinhole<S, RadTan>> shutter_of(const Pinhole<S, RadTan>& cam, S readout_s, const Motion<S>& motion) {
  RollingShutter<Pinhole<S, RadTan>> shutter(cam, height, readout_s);
  shutter.set_motion(motion.w, motion.v, 1 / motion.range);
  return shutter;
}

// Policies name the model of a camera.
static_assert(std::is_same_v<Rolling::Model<Pinhole<float>>, RollingShutter<Pinhole<float>>> && Rolling::rolls);
static_assert(std::is_same_v<Global::Model<Pinhole<float>>, GlobalShutter<Pinhole<float>>> && !Global::rolls);
static_assert(std::is_empty_v<GlobalShutter<Pinhole<float>>>);
}  // namespace

TEMPLATE_TEST_CASE("rolling_shutter: rows of a moving camera, corrected to the middle of the frame", "", float,
                   double) {
  using S = TestType;
  const auto cam = camera<S>();
  testing::Gaussian random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const auto vector = [&] { return Vec<S, 3>{S(random()), S(random()), S(random())}; };
    const Motion<S> motion{S(1.5) * vector(), vector(), S(0.7 + 4 * random.random().uniform())};
    const S readout = S(0.026);
    const auto shutter = shutter_of<S>(cam, readout, motion);
    const Vec<S, 2> still{S(120 + 400 * random.random().uniform()), S(100 + 280 * random.random().uniform())};
    const Vec<S, 2> seen = shutter.seen(still, 1 / motion.range);
    // By definition: row v sees the point from where the camera is at its own time.
    const S t = ((seen.y() + S(0.5)) / S(height) - S(0.5)) * readout;
    const SE3<S> T_middle_row(SO3<S>::exp(Vec<S, 3>(motion.w * t)), Vec<S, 3>(motion.v * t));
    const Vec<S, 3> point = motion.range * cam.unproject(still).bearing;
    const Projection<S> projected = cam.project(T_middle_row.inverse() * point);
    CAPTURE(still.transpose(), seen.transpose(), motion.w.transpose(), motion.v.transpose(), motion.range);
    REQUIRE((projected.uv - seen).norm() < S(0.2));  // 400 deg/s, three steps
    // The range from the row's camera is nearly that from the middle's.
    REQUIRE((shutter.still(seen, 1 / motion.range).uv - still).norm() < S(0.5));
    REQUIRE(shutter.seen(still, S(0)) == seen);  // as far as what it sees
    REQUIRE(shutter.still(seen, S(0)).uv == shutter.still(seen, 1 / motion.range).uv);
  }
}

TEMPLATE_TEST_CASE("rolling_shutter: derivatives are derivatives by the readout", "", float, double) {
  using S = TestType;
  const auto cam = camera<S>();
  const Motion<S> motion{{S(0.4), S(-1.1), S(1.7)}, {S(0.7), S(-0.4), S(0.5)}, S(1.3)};
  const S step = std::is_same_v<S, float> ? S(2e-3) : S(1e-5), tolerance = std::is_same_v<S, float> ? S(1) : S(1e-4);
  for (const S v : {S(20), S(240), S(470)}) {
    const Vec<S, 2> uv(S(200), v);
    const S lambda = 1 / motion.range;
    const auto at = [&](S readout) { return shutter_of<S>(cam, readout, motion); };
    const auto pixel = [&](S readout) { return at(readout).still(uv, lambda).uv; };
    const Vec<S, 2> numeric = (pixel(step) - pixel(-step)) / (2 * step);
    REQUIRE((at(S(0)).still(uv, lambda).derivative.by_readout() - numeric).norm() < tolerance);
    const auto bearing = [&](S readout) { return cam.unproject(pixel(readout)).bearing; };
    const Vec<S, 3> numeric_bearing = (bearing(step) - bearing(-step)) / (2 * step);
    const Vec<S, 3> derivative = at(S(0)).bearing_derivative(uv, bearing(S(0)), lambda).by_readout();
    REQUIRE((derivative - numeric_bearing).norm() < tolerance / 100);
  }
}

TEMPLATE_TEST_CASE("rolling_shutter: a changed depth corrects the row again", "", float, double) {
  using S = TestType;
  const auto cam = camera<S>();
  const S readout = S(0.03);
  const auto shutter = shutter_of<S>(cam, readout, {{S(0.2), S(-0.3), S(0.1)}, {S(0.7), S(-0.4), S(0.5)}, S(3)});
  for (const S v : {S(20), S(240), S(470)}) {
    const Vec<S, 2> uv(S(200), v);
    const auto near = shutter.still(uv, S(0.8));
    auto far = shutter.still(uv, S(0));
    REQUIRE(far.derivative.inverse_range == Approx(1.0 / 3));
    const bool moved = (near.uv - far.uv).norm() > S(1);
    REQUIRE(moved == (v != S(240)));
    far.uv += far.derivative.set_inverse_range(S(0.8), readout);
    REQUIRE((far.uv - near.uv).norm() < S(0.1));
    REQUIRE((far.derivative.by_readout() - near.derivative.by_readout()).norm() < S(4));
    // In another unit of length it is the same.
    const Vec<S, 2> before = far.derivative.by_readout();
    far.derivative.rescale(S(2));
    REQUIRE(far.derivative.inverse_range == Approx(0.4));
    REQUIRE((far.derivative.by_readout() - before).norm() < S(1e-3));
    const Vec<S, 3> ray = cam.unproject(near.uv).bearing;
    auto bearing_far = shutter.bearing_derivative(uv, ray, S(0.1));
    bearing_far.set_inverse_range(S(0.8), readout);
    const auto bearing_near = shutter.bearing_derivative(uv, ray, S(0.8));
    REQUIRE((bearing_far.by_readout() - bearing_near.by_readout()).norm() < S(1e-5));
  }
}

TEST_CASE("rolling_shutter: no readout time, a stationary camera and NaN") {
  const auto cam = camera<double>();
  const Vec<double, 2> uv(77, 33);
  const Motion<double> moving{{1, 2, 3}, {1, 1, 1}};
  REQUIRE((shutter_of<double>(cam, 0.0, moving).still(uv, 1).uv - uv).norm() < 1e-6);
  REQUIRE((RollingShutter(cam, height, 0.03).seen(uv, 1) - uv).norm() < 1e-6);
  const Vec<double, 2> nan(std::nan(""), 33);
  REQUIRE(!shutter_of<double>(cam, 0.03, moving).still(nan, 1).uv.allFinite());
  REQUIRE(shutter_of<double>(cam, 0.03, moving).still(uv, std::nan("")).derivative.inverse_range == 0.5);
}

TEMPLATE_TEST_CASE("rolling_shutter: all rows at once is what a rolling shutter without readout time is", "", float,
                   double) {
  using S = TestType;
  const auto cam = camera<S>();
  const Motion<S> motion{{S(0.4), S(-1.1), S(1.7)}, {S(0.7), S(-0.4), S(0.5)}};
  GlobalShutter<Pinhole<S, RadTan>> global(cam, height, S(0.03));
  global.set_motion(motion.w, motion.v, S(0.5));
  const auto rolling = shutter_of<S>(cam, S(0), motion);
  const Vec<S, 2> uv(S(200), S(33));
  const S tolerance = std::is_same_v<S, float> ? S(1e-2) : S(1e-6);
  REQUIRE(global.still(uv, S(1)).uv == uv);
  REQUIRE(global.seen(uv, S(1)) == uv);
  REQUIRE((rolling.still(uv, S(1)).uv - uv).norm() < tolerance);
  REQUIRE((rolling.seen(uv, S(1)) - uv).norm() < tolerance);
  RollingShutter known(cam, height, S(0), /*is_known=*/true);
  known.set_motion(motion.w, motion.v, S(0.5));
  REQUIRE(known.still(uv, S(1)).uv == uv);
  REQUIRE(known.still(uv, S(1)).derivative.by_readout().isZero(0));
  REQUIRE(rolling.still(uv, S(1)).derivative.by_readout().norm() > S(0.1));
  REQUIRE(global.still(uv, S(1)).derivative.by_readout().isZero(0));
  REQUIRE(global.bearing_derivative(uv, Vec<S, 3>::UnitZ(), S(1)).by_readout().isZero(0));
  REQUIRE(rolling.bearing_derivative(uv, Vec<S, 3>::UnitZ(), S(1)).by_readout().norm() > S(0.1));  // it could have one
}
