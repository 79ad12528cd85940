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

template <class S>
RollingShutter<Pinhole<S, RadTan>> shutter_of(const Pinhole<S, RadTan>& cam, S readout_s, const Vec<S, 3>& rate) {
  RollingShutter<Pinhole<S, RadTan>> shutter(cam, height, readout_s);
  shutter.set_angular_rate(rate);
  return shutter;
}

// Policies name the model of a camera.
static_assert(std::is_same_v<Rolling::Model<Pinhole<float>>, RollingShutter<Pinhole<float>>> && Rolling::rolls);
static_assert(std::is_same_v<Global::Model<Pinhole<float>>, GlobalShutter<Pinhole<float>>> && !Global::rolls);
static_assert(std::is_empty_v<GlobalShutter<Pinhole<float>>>);
}  // namespace

TEMPLATE_TEST_CASE("rolling_shutter: a turning camera's rows, brought to the middle of the frame", "", float, double) {
  using S = TestType;
  const auto cam = camera<S>();
  testing::Gaussian random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const Vec<S, 3> w = S(1.5) * Vec<S, 3>{S(random()), S(random()), S(random())};
    const S readout = S(0.026);
    const auto shutter = shutter_of<S>(cam, readout, w);
    const Vec<S, 2> still{S(120 + 400 * random.random().uniform()), S(100 + 280 * random.random().uniform())};
    const Vec<S, 2> seen = shutter.seen(still);
    // By definition: row v sees the direction at its own time, when the camera has turned by w tau readout.
    const S tau = (seen.y() + S(0.5)) / S(height) - S(0.5);
    const Projection<S> projected =
        cam.project(SO3<S>::exp(Vec<S, 3>(w * tau * readout)).inverse() * cam.unproject(still).bearing);
    CAPTURE(still.transpose(), seen.transpose(), w.transpose());
    REQUIRE((projected.uv - seen).norm() < S(0.2));             // 400 deg/s, three steps
    REQUIRE((shutter.still(seen).uv - still).norm() < S(0.2));  // 400 deg/s, three steps
  }
}

TEMPLATE_TEST_CASE("rolling_shutter: slopes are derivatives by the readout", "", float, double) {
  using S = TestType;
  const auto cam = camera<S>();
  const Vec<S, 3> w(S(0.4), S(-1.1), S(1.7));
  const S step = std::is_same_v<S, float> ? S(2e-3) : S(1e-5), tolerance = std::is_same_v<S, float> ? S(1) : S(1e-4);
  for (const S v : {S(20), S(240), S(470)}) {
    const Vec<S, 2> uv(S(200), v);
    const auto at = [&](S readout) { return shutter_of<S>(cam, readout, w); };
    const Vec<S, 2> numeric = (at(S(0.02) + step).still(uv).uv - at(S(0.02) - step).still(uv).uv) / (2 * step);
    REQUIRE((at(S(0.02)).still(uv).uv_slope - numeric).norm() < tolerance);
    const auto bearing = [&](S readout) { return cam.unproject(at(readout).still(uv).uv).bearing; };
    const Vec<S, 3> numeric_bearing = (bearing(S(0.02) + step) - bearing(S(0.02) - step)) / (2 * step);
    REQUIRE((at(S(0.02)).bearing_slope(uv, bearing(S(0.02))) - numeric_bearing).norm() < tolerance / 100);
  }
}

TEST_CASE("rolling_shutter: no readout time, a camera at rest and NaN") {
  const auto cam = camera<double>();
  const Vec<double, 2> uv(77, 33);
  REQUIRE((shutter_of<double>(cam, 0.0, Vec<double, 3>(1, 2, 3)).still(uv).uv - uv).norm() < 1e-6);
  REQUIRE((RollingShutter(cam, height, 0.03).seen(uv) - uv).norm() < 1e-6);
  const Vec<double, 2> nan(std::nan(""), 33);
  REQUIRE(!shutter_of<double>(cam, 0.03, Vec<double, 3>(1, 0, 0)).still(nan).uv.allFinite());
}

TEMPLATE_TEST_CASE("rolling_shutter: all rows at once is what a rolling shutter without readout time is", "", float,
                   double) {
  using S = TestType;
  const auto cam = camera<S>();
  const Vec<S, 3> w(S(0.4), S(-1.1), S(1.7));
  GlobalShutter<Pinhole<S, RadTan>> global(cam, height, S(0.03));
  global.set_angular_rate(w);
  const auto rolling = shutter_of<S>(cam, S(0), w);
  const Vec<S, 2> uv(S(200), S(33));
  const S tolerance = std::is_same_v<S, float> ? S(1e-2) : S(1e-6);
  REQUIRE(global.still(uv).uv == uv);
  REQUIRE(global.seen(uv) == uv);
  REQUIRE((rolling.still(uv).uv - uv).norm() < tolerance);
  REQUIRE((rolling.seen(uv) - uv).norm() < tolerance);
  RollingShutter known(cam, height, S(0), /*is_known=*/true);
  known.set_angular_rate(w);
  REQUIRE(known.still(uv).uv == uv);
  REQUIRE(known.still(uv).uv_slope.isZero(0));
  REQUIRE(rolling.still(uv).uv_slope.norm() > S(0.1));
  REQUIRE(global.still(uv).uv_slope.isZero(0));
  REQUIRE(global.bearing_slope(uv, Vec<S, 3>::UnitZ()).isZero(0));
  REQUIRE(rolling.bearing_slope(uv, Vec<S, 3>::UnitZ()).norm() > S(0.1));  // it could have one
}
