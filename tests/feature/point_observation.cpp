#include "plumbline/feature/point_observation.hpp"

#include <Eigen/LU>
#include <type_traits>

#include "catch.hpp"

using namespace plumbline;

namespace {

template <class S, bool has_depth, bool rolls>
using Seen = PointObservation<S, has_depth, rolls>;

/// An observation with nothing but a pixel.
template <class S>
struct Plain {
  bool valid;
  Vec<float, 2> pixel, uv;
  Mat<float, 2, 2> L;
};

// A rig without depth keeps none, one with a global shutter no derivatives.
static_assert(sizeof(Seen<float, false, false>) == sizeof(Plain<float>));
static_assert(sizeof(Seen<double, false, false>) == sizeof(Plain<float>));
static_assert(sizeof(Seen<float, false, true>) > sizeof(Seen<float, false, false>));
static_assert(sizeof(Seen<float, true, false>) > sizeof(Seen<float, false, false>));
static_assert(sizeof(Seen<float, true, true>) > sizeof(Seen<float, true, false>));
static_assert(sizeof(Seen<double, true, true>) > sizeof(Seen<double, false, true>));

}  // namespace

TEST_CASE("point_observation: whitening is the square root of the information") {
  Mat<float, 2, 2> A;
  A << 900, 300, 300, 400;
  const Mat<float, 2, 2> L = whitening_of(A, 0.5f, 10);
  const Mat<float, 2, 2> sigma = 0.25f * Mat<float, 2, 2>::Identity() + 100 * A.inverse();
  REQUIRE((L.transpose() * L - sigma.inverse()).norm() < 1e-4f * sigma.inverse().norm());
}

TEST_CASE("point_observation: what slides along an edge does not count along it") {
  Mat<float, 2, 2> edge;
  edge << 10000, 0, 0, 1;
  const Mat<float, 2, 2> L = whitening_of(edge, 0.5f, 10);
  REQUIRE((L * Vec<float, 2>(1, 0)).norm() > 1.5f);
  REQUIRE((L * Vec<float, 2>(0, 1)).norm() < 0.11f);
}

TEMPLATE_TEST_CASE(
    "point_observation: a longer readout moves the pixel along its derivative, the image's pixel not at all", "", float,
    double) {
  using S = TestType;
  Seen<S, true, true> rolling;
  rolling.pixel = rolling.uv = Vec<float, 2>(100, 50);
  rolling.derivative.set({Vec<float, 2>(30, -20), Vec<float, 2>(20, 0), 0.5f});
  rolling.change_readout(S(0.01));
  REQUIRE((rolling.uv - Vec<float, 2>(100.4f, 49.8f)).norm() < 1e-4f);
  REQUIRE(rolling.place() == Vec<float, 2>(100, 50));
  rolling.rescale(S(2));
  rolling.set_inverse_range(S(0.5), S(0.02));  // twice as near
  REQUIRE((rolling.uv - Vec<float, 2>(100.6f, 49.8f)).norm() < 1e-4f);
  REQUIRE(rolling.derivative.get().by_readout() == Vec<float, 2>(50, -20));

  Seen<S, true, false> still;
  still.uv = Vec<float, 2>(100, 50);
  still.derivative.set({Vec<float, 2>(40, -20), Vec<float, 2>(20, 0), 0.5f});
  still.change_readout(S(0.01));
  still.set_inverse_range(S(1), S(0.02));
  REQUIRE(still.uv == Vec<float, 2>(100, 50));
}

TEMPLATE_TEST_CASE("point_observation: larger errors weigh less", "", float, double) {
  using S = TestType;
  Seen<S, false, false> seen;
  seen.scale_sigma(S(2));
  REQUIRE(seen.L == 0.5f * Mat<float, 2, 2>::Identity());
  seen.depth.set({true, S(1), S(0.1)});
  REQUIRE_FALSE(seen.depth.get().valid);  // there is none to keep
}
