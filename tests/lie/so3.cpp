#include "plumbline/lie/so3.hpp"

#include "catch.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;

TEST_CASE("so3: exp of a quarter turn") {
  const SO3<double> R = SO3<double>::exp({0, 0, 1.5707963267948966});
  REQUIRE((R * Vec<double, 3>(1, 0, 0) - Vec<double, 3>(0, 1, 0)).norm() < 1e-15);
}
