#include "plumbline/sensor/rolling_shutter.hpp"

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
}  // namespace

TEMPLATE_TEST_CASE("rolling_shutter: a turning camera's rows, brought to the middle of the frame", "", float, double) {
  using S = TestType;
  const auto cam = camera<S>();
  testing::Gaussian random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const Vec<S, 3> w = S(1.5) * Vec<S, 3>(S(random()), S(random()), S(random()));
    const S readout = S(0.026);
    const RollingShutter<Pinhole<S, RadTan>> shutter(cam, height, readout, w);
    const Vec<S, 2> still(S(120 + 400 * random.random().uniform()), S(100 + 280 * random.random().uniform()));
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
    const auto at = [&](S readout) { return RollingShutter<Pinhole<S, RadTan>>(cam, height, readout, w); };
    const Vec<S, 2> numeric = (at(S(0.02) + step).still(uv).uv - at(S(0.02) - step).still(uv).uv) / (2 * step);
    REQUIRE((at(S(0.02)).still(uv).uv_slope - numeric).norm() < tolerance);
    const auto bearing = [&](S readout) { return cam.unproject(at(readout).still(uv).uv).bearing; };
    const Vec<S, 3> numeric_bearing = (bearing(S(0.02) + step) - bearing(S(0.02) - step)) / (2 * step);
    REQUIRE((at(S(0.02)).bearing_slope(uv, bearing(S(0.02))) - numeric_bearing).norm() < tolerance / 100);
  }
}

TEST_CASE("rolling_shutter: a global shutter, a camera at rest and NaN") {
  const auto cam = camera<double>();
  const Vec<double, 2> uv(77, 33);
  REQUIRE((RollingShutter(cam, height, 0.0, Vec<double, 3>(1, 2, 3)).still(uv).uv - uv).norm() < 1e-6);
  REQUIRE((RollingShutter(cam, height, 0.03, Vec<double, 3>(0, 0, 0)).seen(uv) - uv).norm() < 1e-6);
  const Vec<double, 2> nan(std::nan(""), 33);
  REQUIRE(!RollingShutter(cam, height, 0.03, Vec<double, 3>(1, 0, 0)).still(nan).uv.allFinite());
}
