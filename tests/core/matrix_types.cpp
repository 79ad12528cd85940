#include "plumbline/core/matrix_types.hpp"

#include <cstdint>
#include <type_traits>

#include "catch.hpp"

using namespace plumbline;

namespace {

/// Whether the numbers are a part of the object, so that nothing is allocated.
template <class M>
bool holds_its_numbers(const M& m) {
  const auto begin = reinterpret_cast<std::uintptr_t>(&m), data = reinterpret_cast<std::uintptr_t>(m.data());
  return data >= begin && data + std::size_t(m.size()) * sizeof(m(0)) <= begin + sizeof m;
}
template <class S, int Rows, int Cols>
constexpr int size_of(const Mat<S, Rows, Cols>&) {
  return Rows * Cols;
}

}  // namespace

TEMPLATE_TEST_CASE("matrix_types: sizes are constants, and the numbers are a part of the object", "", float, double) {
  using S = TestType;
  STATIC_REQUIRE(Vec<S, 3>::SizeAtCompileTime == 3);
  STATIC_REQUIRE((Mat<S, 2, 6>::RowsAtCompileTime == 2 && Mat<S, 2, 6>::ColsAtCompileTime == 6));
  STATIC_REQUIRE(std::is_same_v<Vec<S, 4>, Mat<S, 4, 1>>);
  STATIC_REQUIRE(sizeof(Vec<S, 3>) == 3 * sizeof(S));
  STATIC_REQUIRE(sizeof(Mat<S, 15, 15>) >= 225 * sizeof(S));
  CHECK(holds_its_numbers(Vec<S, 3>()));
  CHECK(holds_its_numbers(Mat<S, 60, 60>()));
  CHECK(size_of(Mat<S, 3, 5>()) == 15);  // sizes are deduced
  CHECK(size_of(Vec<S, 3>()) == 3);
}

TEST_CASE("matrix_types: columns follow each other in memory") {
  Mat<float, 2, 3> m;
  m << 1, 2, 3, 4, 5, 6;
  CHECK((m.data()[0] == 1 && m.data()[1] == 4 && m.data()[2] == 2 && m.data()[5] == 6));
}
