#include "plumbline/map/bearing_observation.hpp"

#include "catch.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/testing/gaussian.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;

namespace {

/// Least squares: weights are 1, and the cost is half the sum of squares.
template <class S>
constexpr BundleLosses<S> least_squares{{S(1e6)}, {S(1e6)}};

}  // namespace

TEMPLATE_TEST_CASE("bearing_observation: products are the derivatives of the cost", "", float, double) {
  using S = TestType;
  testing::Gaussian noise(1);
  for (int n = 0; n < 20; ++n) {
    const SE3<double> T(SO3<double>::exp(noise.vector<3>()), noise.vector<3>());
    const Vec<double, 3> p_cam = Vec<double, 3>(0, 0, 4) + noise.vector<3>();
    const Vec<double, 3> bearing = (p_cam.normalized() + 0.05 * noise.vector<3>()).normalized(), X = T * p_cam;
    const double range = n % 2 == 0 ? 0 : p_cam.norm() * 1.1;
    const BearingObservation<double> exact(bearing, 0.1, range, 0.5);
    const BearingObservation<S> seen(cast_to<S>(bearing), S(0.1), S(range), S(0.5));
    const auto out = seen.products(BodyView<S>(T.cast<S>(), {}), cast_to<S>(X), least_squares<S>);
    const Vec<double, 3> a = X - T.p();
    Mat<double, 3, 6> E;
    E << hat(a), -identity<double, 3>();
    const auto cost = [&](const SE3<double>& T_map_cam, const Vec<double, 3>& p) {
      return Vec<double, 1>(exact.cost(exact.errors(BodyView<double>(T_map_cam, {}), p), least_squares<double>) / 2);
    };
    const double tolerance = std::is_same_v<S, float> ? 1e-4 : 1e-8;
    const Mat<double, 1, 3> by_point = out.g.transpose();
    CHECK(testing::jacobian_error(
              by_point, [&](const Vec<double, 3>& p) { return cost(T, p); }, X) < tolerance);
    Mat<double, 6, 6> right = zeros<double, 6, 6>();  // increments in axes of the map from right ones
    set_block(right, 0, 0, T.R());
    set_block(right, 3, 3, T.R());
    const Mat<double, 1, 6> by_pose = out.g.transpose() * E * right;  // (4)
    CHECK(testing::jacobian_error(
              by_pose, [&](const SE3<double>& pose) { return cost(pose, X); }, T) < tolerance);
  }
}

TEMPLATE_TEST_CASE("bearing_observation: G is the Hessian of an exact measurement", "", float, double) {
  using S = TestType;
  testing::Gaussian noise(2);
  for (int n = 0; n < 20; ++n) {
    const Vec<double, 3> X = Vec<double, 3>(0, 0, 4) + noise.vector<3>();
    const double range = n % 2 == 0 ? 0 : X.norm();
    const BearingObservation<double> exact(X.normalized(), 0.1, range, 0.5);
    const BearingObservation<S> seen(cast_to<S>(X.normalized().eval()), S(0.1), S(range), S(0.5));
    const auto out = seen.products(BodyView<S>(SE3<S>(), {}), cast_to<S>(X), least_squares<S>);
    const auto gradient = [&](const Vec<double, 3>& p) {
      return exact.products(BodyView<double>(SE3<double>(), {}), p, least_squares<double>).g;
    };
    CHECK(testing::jacobian_error(out.G, gradient, X) < (std::is_same_v<S, float> ? 1e-4 : 1e-6));
    CHECK((out.G - out.G.transpose()).norm() < 1e-12 * out.G.norm());
  }
}

TEMPLATE_TEST_CASE("bearing_observation: kernels, and the end of the domain", "", float, double) {
  using S = TestType;
  const BundleLosses<S> losses{{S(2)}, {S(1)}};
  const BodyView<S> view(SE3<S>(), {});
  const Vec<S, 3> b(S(0), S(0), S(1));
  const BearingObservation<S> seen(b, S(0.01), S(5), S(1));
  CHECK(seen.errors(view, {S(0.05), S(0), S(5)}).bearing == Approx(1));
  CHECK(seen.errors(view, {S(0), S(0), S(6)}).range == Approx(25 * (0.2 - 1 / 6.0) * 25 * (0.2 - 1 / 6.0)));
  CHECK(seen.cost(seen.errors(view, {S(0.05), S(0), S(5)}), losses) == Approx(1));
  CHECK(seen.cost(seen.errors(view, {S(0.5), S(0), S(5)}), losses) == Approx(2 * 2 * 10 - 4));
  const auto products = seen.products(view, {S(0.5), S(0), S(5)}, losses);
  CHECK(products.g[0] == Approx(0.2 * 10 * 100 / 5));
  // Behind the camera and beyond 84 degrees: as much as at the border, and no derivative.
  const S border = seen.cost(seen.errors(view, {S(99.9), S(0), S(10)}), losses);
  for (const Vec<S, 3>& p :
       {Vec<S, 3>(S(0), S(0), S(-5)), Vec<S, 3>(S(101), S(0), S(10)), Vec<S, 3>(S(0), S(0), S(0))}) {
    CHECK(!seen.errors(view, p).valid);
    CHECK(double(seen.cost(seen.errors(view, p), losses)) == Approx(double(border)).epsilon(0.01));
    CHECK(seen.products(view, p, losses).G.norm() == 0);
    CHECK(seen.products(view, p, losses).g.norm() == 0);
  }
}
