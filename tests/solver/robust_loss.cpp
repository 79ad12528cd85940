#include "plumbline/solver/robust_loss.hpp"

#include <limits>

#include "catch.hpp"

using namespace plumbline;

namespace {

/// rho' and rho'' against central differences in double, away from the kernels' corners.
template <class Loss>
void check_derivatives(const Loss& loss) {
  const double h = 1e-4;
  REQUIRE(loss.rho(0.0) == 0.0);
  for (const double s : {0.01, 0.5, 1.5, 3.0, 8.0, 20.0, 100.0}) {
    const double first = (loss.rho(s + h) - loss.rho(s - h)) / (2 * h);
    const double second = (loss.weight(s + h) - loss.weight(s - h)) / (2 * h);
    REQUIRE(loss.weight(s) == Approx(first).epsilon(1e-7).margin(1e-9));
    REQUIRE(loss.second(s) == Approx(second).epsilon(1e-6).margin(1e-9));
    REQUIRE(loss.weight(s) >= 0);
    REQUIRE(loss.second(s) <= 0);
  }
}

template <template <class> class Loss>
void check_float_like_double() {
  for (const double s : {0.0, 0.3, 2.0, 30.0, 1e4}) {
    REQUIRE(Loss<float>().rho(float(s)) == Approx(Loss<double>().rho(s)).epsilon(1e-5).margin(1e-5));
    REQUIRE(Loss<float>().weight(float(s)) == Approx(Loss<double>().weight(s)).epsilon(1e-5).margin(1e-6));
  }
  const float nan = std::numeric_limits<float>::quiet_NaN();
  REQUIRE_FALSE(Loss<float>().rho(nan) < std::numeric_limits<float>::infinity());  // a NaN is never a small cost
}

}  // namespace

TEST_CASE("robust_loss: weight and second are the derivatives of rho") {
  check_derivatives(NoLoss<double>());
  check_derivatives(Huber<double>());
  check_derivatives(Huber<double>{2.4477});
  check_derivatives(Cauchy<double>());
  check_derivatives(Tukey<double>());
  check_derivatives(StudentT<double>());
  check_derivatives(GemanMcClure<double>());
}

TEST_CASE("robust_loss: float agrees with double and keeps a NaN") {
  check_float_like_double<NoLoss>();
  check_float_like_double<Huber>();
  check_float_like_double<Cauchy>();
  check_float_like_double<Tukey>();
  check_float_like_double<StudentT>();
  check_float_like_double<GemanMcClure>();
}

TEST_CASE("robust_loss: weights of the reference") {
  REQUIRE(Huber<double>().weight(1.345 * 1.345) == 1.0);
  REQUIRE(Huber<double>().weight(4 * 1.345 * 1.345) == Approx(0.5));
  REQUIRE(Cauchy<double>().weight(2.385 * 2.385) == Approx(0.5));
  REQUIRE(Tukey<double>().weight(4.685 * 4.685 / 2) == Approx(0.25));
  REQUIRE(Tukey<double>().weight(22.0) == 0.0);
  REQUIRE(Tukey<double>().rho(1e6) == Approx(4.685 * 4.685 / 3));
  REQUIRE(StudentT<double>().weight(1.0) == Approx(1.0));
  REQUIRE(GemanMcClure<double>{2.0}.weight(2.0) == Approx(0.25));
  REQUIRE(GemanMcClure<double>{2.0}.rho(1e12) == Approx(2.0));
}

TEST_CASE("robust_loss: a kernel has its own width for the rows of a residual") {
  STATIC_REQUIRE(loss_for<Huber, double, 1>.c == 1.345);
  STATIC_REQUIRE(loss_for<Huber, double, 2>.c == 2.45);
  STATIC_REQUIRE(loss_for<Huber, float, 3>.c > 2.79f);
  STATIC_REQUIRE(loss_for<Tukey, double, 2>.c == 4.685);  // has no width for rows
}
