#include "plumbline/feature/line_rows.hpp"

#include <cmath>
#include <type_traits>
#include <vector>

#include "catch.hpp"
#include "feature/seen_lines.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/solver/robust_loss.hpp"

using namespace plumbline;

namespace {

template <class S, bool has_depth = true>
using Seen = SegmentObservation<S, has_depth, true>;

/// Through two points in the camera; seen so many pixels beside itself.
template <class S>
Plucker<S> true_line() {
  return Line3<double>::through({-0.4, 0.1, 2}, {0.4, 0.3, 2.5}).template cast<S>().plucker();
}
template <class Observation>
Observation observed(double off_px) {
  const Pinhole<double> camera{100, 100, 31.5, 31.5, {}};
  testing::Gaussian noise(1);
  const Vec<double, 3> p(-0.4, 0.1, 2), q(0.4, 0.3, 2.5), up(0, -0.01 * off_px, 0);
  return test::observe_segment<Observation>(camera, p + p.z() * up, q + q.z() * up, 0, noise);
}
template <class S, bool has_depth = true>
using Rows = LineRows<Seen<S, has_depth>, Huber<S>>;
template <class S>
constexpr Huber<S> loss{S(2.45)};

/// Keeps the derivatives that it is given.
struct Derivatives {
  std::vector<double> all;
  template <class S, int R>
  void add_derivatives(const Vec<S, R>& some) {
    for (int k = 0; k < R; ++k) all.push_back(double(some[k]));
  }
};

template <class S>
constexpr double tolerance = std::is_same_v<S, float> ? 1e-3 : 1e-9;

}  // namespace

TEMPLATE_TEST_CASE("line_rows: residual and Jacobians of segment and depth, whitened and weighted each", "", float,
                   double) {
  using S = TestType;
  for (const double off_px : {0.2, 8.0}) {  // an inlier and an outlier
    CAPTURE(off_px);
    const auto seen = observed<Seen<S>>(off_px);
    const Plucker<S> line = true_line<S>();
    const Rows<S> rows(seen, line, loss<S>);
    REQUIRE(rows.rows == 4);
    const auto& pixels = seen.pixels;
    const auto lin = pixels.measured.linearize(line);
    const Vec<S, 2> r = pixels.L * lin.r;
    const S w = std::sqrt(loss<S>.weight(squared_norm(r)));
    CHECK((w < S(1)) == (off_px > 1));
    CHECK(norm(Vec<S, 2>(segment<2>(rows.lin.r, 0) - w * r)) < tolerance<S>);
    CHECK((block<2, 3>(rows.lin.J_r_n, 0, 0) - w * pixels.L * lin.J_r_n).norm() < tolerance<S> * lin.J_r_n.norm());
    const auto& depth = seen.depth.get();
    const Vec<S, 2> r_z = depth.L * depth.measured.residual(line);
    const S w_z = std::sqrt(loss<S>.weight(squared_norm(r_z)));
    CHECK(norm(Vec<S, 2>(segment<2>(rows.lin.r, 2) - w_z * r_z)) < tolerance<S>);
    CHECK(rows.cost == Approx(double(loss<S>.rho(squared_norm(r)) + loss<S>.rho(squared_norm(r_z))) / 2).margin(1e-6));
  }
}

TEMPLATE_TEST_CASE("line_rows: without a depth, or of the segment alone, those of depth are zero", "", float, double) {
  using S = TestType;
  auto seen = observed<Seen<S>>(1);
  const Rows<S> alone(seen.pixels, true_line<S>(), loss<S>);
  seen.clear_depth();
  const Rows<S> without(seen, true_line<S>(), loss<S>);
  for (const Rows<S>* rows : {&alone, &without}) {
    CHECK(rows->rows == 2);
    CHECK((segment<2>(rows->lin.r, 2).isZero(0) && block<2, 3>(rows->lin.J_r_v, 2, 0).isZero(0)));
    CHECK(norm(segment<2>(rows->lin.r, 0)) > 0);
  }
  CHECK(alone.cost == without.cost);
  const Rows<S, false> mono(observed<Seen<S, false>>(1), true_line<S>(), loss<S>);
  STATIC_REQUIRE(Rows<S, false>::max_rows == 2);
  CHECK((mono.rows == 2 && mono.cost == Approx(alone.cost)));
}

TEST_CASE("line_rows: a line that is not visible has none, and costs more than any inlier") {
  const auto seen = observed<Seen<double>>(0);
  const Plucker<double> line = true_line<double>();
  const Rows<double> rows(seen, Plucker<double>{Vec<double, 3>(-line.n), line.v}, loss<double>);
  CHECK(rows.rows == 0);
  CHECK(rows.cost == Rows<double>::invalid_cost);
  CHECK(rows.lin.r.isZero(0));
  Derivatives derivatives;
  rows.add_derivatives(derivatives, seen, line);
  CHECK(derivatives.all.empty());
}

TEST_CASE("line_rows: derivatives by the readout time are those of the residual, zero for depth") {
  const auto seen = observed<Seen<double>>(1);
  const Plucker<double> line = true_line<double>();
  const Rows<double> rows(seen, line, loss<double>);
  Derivatives derivatives;
  rows.add_derivatives(derivatives, seen, line);
  REQUIRE(derivatives.all.size() == 4);
  const double step = 1e-6;
  auto later = seen, earlier = seen;
  later.change_readout(step);
  earlier.change_readout(-step);
  const Vec<double, 2> numeric =
      rows.wL * Vec<double, 2>(later.pixels.measured.residual(line) - earlier.pixels.measured.residual(line)) /
      (2 * step);
  CHECK(numeric.norm() > 1);
  for (int k = 0; k < 2; ++k) CHECK(derivatives.all[std::size_t(k)] == Approx(numeric[k]).epsilon(1e-5));
  CHECK((derivatives.all[2] == 0 && derivatives.all[3] == 0));
}
