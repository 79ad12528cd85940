#include "plumbline/core/fixed_vector.hpp"

#include <numeric>
#include <utility>

#include "catch.hpp"

using namespace plumbline;

TEST_CASE("fixed_vector: grows to its capacity and refuses more") {
  FixedVector<int, 3> v;
  static_assert(FixedVector<int, 3>::capacity() == 3);
  CHECK(v.empty());
  CHECK(v.push_back(1));
  CHECK(v.push_back(2));
  CHECK(!v.full());
  CHECK(v.push_back(3));
  CHECK(v.full());
  CHECK(!v.push_back(4));
  CHECK(v.size() == 3);
  CHECK(v.back() == 3);
  CHECK(std::accumulate(v.begin(), v.end(), 0) == 6);
  v.pop_back();
  CHECK(v.size() == 2);
  CHECK(v.back() == 2);
  v.clear();
  CHECK(v.empty());
  CHECK(v.begin() == v.end());
}

TEST_CASE("fixed_vector: resize fills with default values, also where items have been") {
  FixedVector<int, 4> v;
  for (int i = 1; i <= 4; ++i) v.push_back(i);
  v.resize(1);
  v.resize(3);
  CHECK(v.size() == 3);
  CHECK(v[0] == 1);
  CHECK(v[1] == 0);
  CHECK(v[2] == 0);
}

TEST_CASE("fixed_vector: swap_remove fills the gap with the last item") {
  FixedVector<int, 4> v;
  for (int i = 0; i < 4; ++i) v.push_back(i);
  v.swap_remove(1);
  CHECK(v.size() == 3);
  CHECK(v[0] == 0);
  CHECK(v[1] == 3);
  CHECK(v[2] == 2);
  v.swap_remove(2);  // the last one itself
  CHECK(v.size() == 2);
  CHECK(v[1] == 3);
}

TEST_CASE("fixed_vector: holds move-only items and copies by value") {
  struct MoveOnly {
    int value = 0;
    MoveOnly() = default;
    explicit MoveOnly(int v) : value(v) {}
    MoveOnly(MoveOnly&&) = default;
    MoveOnly& operator=(MoveOnly&&) = default;
  };
  FixedVector<MoveOnly, 2> v;
  CHECK(v.push_back(MoveOnly(7)));
  CHECK(v[0].value == 7);

  FixedVector<int, 2> a;
  a.push_back(1);
  FixedVector<int, 2> b = a;
  b[0] = 5;
  CHECK(a[0] == 1);
  CHECK(std::as_const(b).data()[0] == 5);
}
