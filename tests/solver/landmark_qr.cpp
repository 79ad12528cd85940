#include "plumbline/solver/landmark_qr.hpp"

#include <cmath>

#include <Eigen/Core>

#include "catch.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

template <class S, int Dim>
void factors_are_those_of_the_rows() {
  using Qr = LandmarkQr<S, Dim, 12, double>;
  using Matrix = Eigen::MatrixXd;
  testing::Gaussian noise(7);
  for (const double mu : {0.0, 1e-4, 1.0}) {
    for (int rows = Dim; rows <= 12; ++rows) {
      typename Qr::Rows J{};
      Matrix damped = Matrix::Zero(rows + Dim, Dim);
      for (int k = 0; k < rows; ++k) {
        for (int l = 0; l < Dim; ++l) damped(k, l) = double(J[std::size_t(k)][std::size_t(l)] = S(noise()));
      }
      Qr qr;
      typename Qr::Columns columns{};
      REQUIRE(qr.factorize(J, rows, mu, columns));
      for (int l = 0; l < Dim; ++l) damped(rows + l, l) = std::sqrt(mu * qr.damping()[l]);
      Matrix R(Dim, Dim);
      for (int l = 0; l < Dim; ++l) R.row(l) = qr.row(l).transpose();
      CHECK((R.transpose() * R - damped.transpose() * damped).norm() < 1e-12 * damped.squaredNorm());
      Matrix Q(rows, Dim);  // those of J alone
      for (int l = 0; l < Dim; ++l) {
        for (int k = 0; k < rows; ++k) Q(k, l) = columns[std::size_t(l)][std::size_t(k)];
      }
      CHECK((Q * R - damped.topRows(rows)).norm() < 1e-12 * damped.norm());
      const Vec<double, Dim> b = noise.template vector<Dim>();
      Vec<double, Dim> x = b;
      qr.solve(x);
      CHECK((R * x - b).norm() < 1e-10 * (1 + x.norm() * R.norm()));
    }
  }
}

}  // namespace

TEMPLATE_TEST_CASE("landmark_qr: factors are those of the rows and their damping", "", float, double) {
  factors_are_those_of_the_rows<TestType, 1>();
  factors_are_those_of_the_rows<TestType, 2>();
  factors_are_those_of_the_rows<TestType, 4>();
}

TEST_CASE("landmark_qr: what is not determined has no factors, until it is damped") {
  using Qr = LandmarkQr<double, 2, 4, double>;
  Qr qr;
  Qr::Columns Q;
  Qr::Rows J{};
  for (std::size_t k = 0; k < 4; ++k) J[k] = {1 + double(k), 2 * (1 + double(k))};
  CHECK_FALSE(qr.factorize(J, 4, 0, Q));
  CHECK_FALSE(qr.factorize(J, 1, 0, Q));
  CHECK(qr.factorize(J, 4, 1e-2, Q));
  J[2][1] = NAN;
  CHECK_FALSE(qr.factorize(J, 4, 1e-2, Q));
}
