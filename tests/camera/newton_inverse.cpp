#include "plumbline/camera/newton_inverse.hpp"

#include "catch.hpp"

using namespace plumbline;

namespace {

/// m' = (m_x + m_x^3, m_y + m_x m_y), where it can be inverted.
template <class S>
struct Cubic {
  using Distorted = typename NoDistortion<S>::Distorted;
  Distorted distort(const Vec<S, 2>& m) const {
    Distorted out;
    out.valid = m.x() > S(-0.5);
    out.m << m.x() + m.x() * m.x() * m.x(), m.y() + m.x() * m.y();
    out.J << 1 + 3 * m.x() * m.x(), 0, m.y(), 1 + m.x();
    return out;
  }
};

}  // namespace

TEMPLATE_TEST_CASE("newton_inverse: finds the point and the inverse Jacobian", "", float, double) {
  using S = TestType;
  const Vec<S, 2> m(S(0.7), S(-0.3));
  const auto forward = Cubic<S>().distort(m);
  const auto back = newton_inverse<S>(Cubic<S>(), forward.m);
  REQUIRE(back.valid);
  const S tolerance = std::is_same_v<S, float> ? S(1e-6) : S(1e-14);
  CHECK((back.m - m).norm() < tolerance);
  CHECK((back.J * forward.J - Mat<S, 2, 2>::Identity()).norm() < 10 * tolerance);
}

TEMPLATE_TEST_CASE("newton_inverse: no point of the domain", "", float, double) {
  using S = TestType;
  CHECK(!newton_inverse<S>(Cubic<S>(), {S(-0.8), 0}).valid);
  CHECK(!newton_inverse<S>(Cubic<S>(), {std::numeric_limits<S>::quiet_NaN(), 0}).valid);
}
