// The derivatives of rows by the readout time, against what the rows become when everything seen moves along with it.
#include "plumbline/feature/readout_derivatives.hpp"

#include <type_traits>

#include "catch.hpp"
#include "feature/seen_lines.hpp"
#include "feature/seen_points.hpp"
#include "plumbline/feature/window_terms.hpp"
#include "plumbline/sensor/mono.hpp"

using namespace plumbline;
using test::SeenLines;
using test::SeenPoints;

namespace {

template <class S>
using MonoRig = Rig<Mono<Pinhole<S>, 64 * 64, Rolling>>;

/// All of a bearing or a pixel, whatever the shutter did.
template <class S, int N>
RowDerivative<S, N> derivative(testing::Gaussian& noise, double size) {
  const auto random = [&] { return Vec<S, N>((size * noise.vector<N>()).template cast<S>()); };
  return {random(), random(), S(0.4)};
}
template <class S>
RowDerivative<S, 3> derivative_of(const Vec<S, 3>& bearing, testing::Gaussian& noise) {
  RowDerivative<S, 3> out = derivative<S, 3>(noise, 0.5);
  for (Vec<S, 3>* part : {&out.by_rotation, &out.by_translation}) *part -= part->dot(bearing) * bearing;
  return out;
}
template <class S, bool depth>
void tilt(PointObservation<S, depth, true>& seen, testing::Gaussian& noise) {
  seen.derivative.set(derivative<float, 2>(noise, 300));
}
template <class S, bool depth>
void tilt(SegmentObservation<S, depth, true>& seen, testing::Gaussian& noise) {
  const auto& ends = seen.pixels.measured;
  seen.derivatives.set({derivative_of(ends.bearing_start, noise), derivative_of(ends.bearing_end, noise)});
}
/// A point is defined by its anchor's bearing, a line by nothing.
template <class Kind>
void tilt_geometry(typename Kind::Geometry& geometry, testing::Gaussian& noise) {
  if constexpr (Kind::dim == 1) geometry.derivative.set(derivative_of(geometry.bearing, noise));
}
template <class Kind, class S>
void change_geometry(typename Kind::Geometry& geometry, S change_s) {
  if constexpr (Kind::dim == 1) Kind::change_readout(geometry, {}, change_s);
}

}  // namespace

#define SCENES                                                                                                       \
  SeenPoints<float>, SeenPoints<double>, (SeenPoints<double, MonoRig<double>>), SeenLines<float>, SeenLines<double>, \
      (SeenLines<double, MonoRig<double>>)

TEMPLATE_TEST_CASE("readout_derivatives: are the derivatives of the rows, anchor's and others', in their order", "",
                   SCENES) {
  using Seen = TestType;
  using Kind = typename Seen::Kind;
  using S = typename Kind::Scalar;
  using Terms = WindowTerms<typename Seen::Store>;
  constexpr bool single = std::is_same_v<S, float>;
  Seen scene(6, 0.2);  // nothing is beyond the kernel's quadratic part, where a weight would change as well
  testing::Gaussian noise(7);
  const S delta = S(2e-4);
  int compared = 0;
  for (auto& landmark : scene.store->landmarks()) {
    for (auto& seen : landmark.observations) {
      if (seen.valid) tilt(seen, noise);
    }
    tilt_geometry<Kind>(landmark.geometry, noise);
    for (int slot = 0; slot < Seen::used; ++slot) {
      const auto& seen = landmark.observations[std::size_t(slot)];
      if (!seen.valid) continue;
      const RelativeView<S> view(scene.window.T_world_body(landmark.anchor), scene.window.T_world_body(slot),
                                 scene.T_body_cam.template cast<S>());
      const auto add = [&](const auto& geometry, const auto& observation, auto& rows) {
        const typename Kind::Linearized linearized(geometry);
        if (slot == landmark.anchor) {
          Kind::add_anchor(linearized, observation, rows);
        } else {
          Kind::add_view(scene.rig, linearized, observation, view, slot, rows);
        }
      };
      const auto rows_at = [&](S change_s) {
        auto geometry = landmark.geometry;
        auto observation = seen;
        change_geometry<Kind>(geometry, change_s);
        observation.change_readout(change_s);
        typename Terms::Elimination rows;
        rows.reset(landmark.anchor);
        add(geometry, observation, rows);
        return rows;
      };
      typename Terms::Derivatives derivatives;
      add(landmark.geometry, seen, derivatives);
      const auto plus = rows_at(delta), minus = rows_at(-delta);
      REQUIRE(derivatives.rows() == plus.rows());
      for (int k = 0; k < derivatives.rows(); ++k) {
        const double expected = (double(plus.residual(k)) - double(minus.residual(k))) / (2 * double(delta));
        CAPTURE(slot, k, expected, derivatives[k]);
        if (Kind::dim == 4 && k >= 2) {  // the depth of lines neglects it
          REQUIRE(derivatives[k] == S(0));
          continue;
        }
        REQUIRE(std::abs(double(derivatives[k]) - expected) < (single ? 0.02 : 2e-3) * (std::abs(expected) + 50));
        ++compared;
      }
      REQUIRE(derivatives[derivatives.rows()] == S(0));
    }
  }
  REQUIRE(compared > 30);
}

TEST_CASE("readout_derivatives: rows of a kind without derivatives have none") {
  ReadoutDerivatives<double, 5> derivatives;
  derivatives.add_derivatives(Vec<double, 1>(3.0));
  derivatives.add<2>(0, 0, 0, 0);
  derivatives.add<1>(0, 0);
  REQUIRE(derivatives.rows() == 4);
  REQUIRE(derivatives[0] == 3);
  for (int k = 1; k < 6; ++k) REQUIRE(derivatives[k] == 0);
  derivatives.add_derivatives(Vec<double, 2>(4.0, 5.0));  // more than there is room for
  REQUIRE(derivatives.rows() == 5);
  REQUIRE(derivatives[4] == 4);
}
