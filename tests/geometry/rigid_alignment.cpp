#include "plumbline/geometry/rigid_alignment.hpp"

#include <limits>
#include <vector>

#include "catch.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/lie/plus.hpp"

using namespace plumbline;

namespace {

Vec<double, 3> random_vector(Random& random) {
  return {2 * random.uniform() - 1, 2 * random.uniform() - 1, 2 * random.uniform() - 1};
}

Sim3<double> random_similarity(Random& random) {
  Vec<double, 7> xi;
  xi << 3 * random_vector(random), 4 * random_vector(random), 2 * random.uniform() - 1;
  return Sim3<double>::exp(xi);
}

}  // namespace

TEMPLATE_TEST_CASE("rigid_alignment: recovers the transform, planar sets and mirror-prone noise included", "", float,
                   double) {
  using S = TestType;
  Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const bool with_scale = trial % 2, planar = trial % 4 < 2;
    Sim3<double> X = random_similarity(random);
    if (!with_scale) X = Sim3<double>(1, X.rotation(), X.t());
    RigidAlignment<S> alignment;
    const int count = 3 + trial % 20;
    for (int i = 0; i < count; ++i) {
      Vec<double, 3> q = random_vector(random);
      if (planar) q.z() = 0;
      alignment.add((X * q).cast<S>(), q.cast<S>(), S(0.1 + random.uniform()));
    }
    const auto result = alignment.solve(with_scale);
    if (!result.valid) continue;  // three random points may be nearly collinear
    CHECK(alignment.count() == count);
    CHECK(minus(result.S_p_q.template cast<double>(), X).norm() < (std::is_same_v<S, float> ? 2e-3 : 1e-11));
  }
}

TEST_CASE("rigid_alignment: is the weighted minimum") {
  Random random(2);
  const Sim3<double> X = random_similarity(random);
  std::vector<Vec<double, 3>> ps, qs;
  std::vector<double> weights;
  for (int i = 0; i < 40; ++i) {
    qs.push_back(random_vector(random));
    ps.push_back(X * qs.back() + 0.3 * random_vector(random));
    weights.push_back(0.1 + random.uniform());
  }
  const auto cost = [&](const Sim3<double>& T) {
    double sum = 0;
    for (std::size_t i = 0; i < ps.size(); ++i) sum += weights[i] * (ps[i] - T * qs[i]).squaredNorm();
    return sum;
  };
  for (const bool with_scale : {false, true}) {
    RigidAlignment<double> alignment;
    for (std::size_t i = 0; i < ps.size(); ++i) alignment.add(ps[i], qs[i], weights[i]);
    const auto result = alignment.solve(with_scale);
    REQUIRE(result.valid);
    for (int i = 0; i < (with_scale ? 7 : 6); ++i) {
      for (const double h : {-1e-3, 1e-3}) {
        const Vec<double, 7> d = h * Vec<double, 7>::Unit(i);
        CHECK(cost(plus(result.S_p_q, d)) > cost(result.S_p_q));
      }
    }
    CHECK((with_scale || result.S_p_q.scale() == 1.0));
  }
}

TEMPLATE_TEST_CASE("rigid_alignment: never a reflection", "", float, double) {
  using S = TestType;
  RigidAlignment<S> alignment;  // p is the mirror image of q
  for (const Vec<S, 3>& q : {Vec<S, 3>(1, 0, 0), Vec<S, 3>(0, 2, 0), Vec<S, 3>(0, 0, 3), Vec<S, 3>(-1, -1, -1)}) {
    alignment.add(Vec<S, 3>(-q.x(), q.y(), q.z()), q);
  }
  const auto result = alignment.solve(false);
  REQUIRE(result.valid);
  CHECK(std::abs(result.S_p_q.R().determinant() - 1) < S(1e-5));
}

TEMPLATE_TEST_CASE("rigid_alignment: far from the origin", "", float, double) {
  using S = TestType;
  const Vec<S, 3> offset(4000, -3000, 100);
  Random random(5);
  RigidAlignment<S> alignment;
  for (int i = 0; i < 1000; ++i) {
    const Vec<S, 3> q = offset + S(10) * random_vector(random).cast<S>();
    alignment.add(q - offset, q);
  }
  const auto result = alignment.solve(true);
  REQUIRE(result.valid);
  CHECK(std::abs(result.S_p_q.scale() - 1) < (std::is_same_v<S, float> ? S(1e-4) : S(1e-12)));
  CHECK(result.S_p_q.rotation().log().norm() < (std::is_same_v<S, float> ? S(1e-4) : S(1e-12)));
}

TEMPLATE_TEST_CASE("rigid_alignment: rejects collinear, too few, NaN", "", float, double) {
  using S = TestType;
  RigidAlignment<S> line, two, poisoned, same;
  for (int i = 0; i < 10; ++i) line.add({S(i), S(2 * i), S(0)}, {S(0), S(i), S(2 * i)});
  CHECK(!line.solve(true).valid);
  CHECK(!line.solve(false).valid);
  two.add({1, 0, 0}, {0, 1, 0});
  two.add({0, 1, 0}, {1, 0, 0});
  CHECK(!two.solve(false).valid);
  CHECK(!RigidAlignment<S>().solve(true).valid);
  for (int i = 0; i < 5; ++i) same.add({1, 2, 3}, {4, 5, 6});
  CHECK(!same.solve(true).valid);
  for (int i = 0; i < 5; ++i)
    poisoned.add({S(i), S(i * i), 0}, {S(i), S(i * i), i == 3 ? std::numeric_limits<S>::quiet_NaN() : S(0)});
  CHECK(!poisoned.solve(true).valid);
}
