#include "plumbline/geometry/p3p.hpp"

#include <algorithm>
#include <limits>

#include "catch.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/lie/plus.hpp"

using namespace plumbline;

namespace {

double symmetric(Random& random) { return 2 * random.uniform() - 1; }

template <class S>
Vec<S, 3> random_vector(Random& random) {
  return Vec<double, 3>(symmetric(random), symmetric(random), symmetric(random)).cast<S>();
}

template <class S>
struct Problem {
  SE3<S> T_cam_world;
  std::array<Vec<S, 3>, 3> bearings, points_world;
};

/// Three points 1 to 8 m in front of the camera, exact in double.
template <class S>
Problem<S> random_problem(Random& random) {
  Vec<double, 6> xi;
  xi << 3 * random_vector<double>(random), 2 * random_vector<double>(random);
  const SE3<double> T = SE3<double>::exp(xi);
  Problem<S> out;
  out.T_cam_world = T.cast<S>();
  for (std::size_t i = 0; i < 3; ++i) {
    const double z = 1 + 7 * random.uniform();
    const Vec<double, 3> p_cam(z * symmetric(random), z * symmetric(random), z);
    out.bearings[i] = p_cam.normalized().cast<S>();
    out.points_world[i] = (T.inverse() * p_cam).cast<S>();
  }
  return out;
}

template <class S>
double error_of(const FixedVector<SE3<S>, 4>& candidates, const SE3<S>& truth) {
  double best = std::numeric_limits<double>::infinity();
  for (const SE3<S>& T : candidates) best = std::min(best, double(minus(T, truth).norm()));
  return best;
}

}  // namespace

TEMPLATE_TEST_CASE("p3p: the true pose is among the candidates", "", float, double) {
  using S = TestType;
  Random random(7);
  const int trials = 20000;
  int missed = 0, candidates_total = 0;
  for (int i = 0; i < trials; ++i) {
    const Problem<S> problem = random_problem<S>(random);
    const FixedVector<SE3<S>, 4> candidates = p3p(problem.bearings, problem.points_world);
    candidates_total += int(candidates.size());
    missed += !(error_of(candidates, problem.T_cam_world) < (std::is_same_v<S, float> ? 2e-2 : 1e-6));
    for (const SE3<S>& T : candidates) {
      REQUIRE(T.is_finite());
      for (std::size_t k = 0; k < 3; ++k) {  // every candidate explains the three bearings
        const Vec<S, 3> p_cam = T * problem.points_world[k];
        REQUIRE((p_cam.normalized() - problem.bearings[k]).norm() < (std::is_same_v<S, float> ? S(1e-2) : S(1e-7)));
      }
    }
  }
  CAPTURE(missed, candidates_total);
  CHECK(missed < trials * (std::is_same_v<S, float> ? 0.01 : 1e-4));  // near double solutions
  CHECK(candidates_total > trials);
}

TEMPLATE_TEST_CASE("p3p: symmetric configurations", "", float, double) {
  using S = TestType;
  // The camera on the axis of an equilateral triangle: repeated solutions, the double roots of the cubic.
  Problem<S> problem;
  for (std::size_t i = 0; i < 3; ++i) {
    const double angle = 2.0943951023931953 * double(i);
    problem.points_world[i] = Vec<double, 3>(std::cos(angle), std::sin(angle), 3).cast<S>();
    problem.bearings[i] = problem.points_world[i].normalized();
  }
  const FixedVector<SE3<S>, 4> candidates = p3p(problem.bearings, problem.points_world);
  REQUIRE(error_of(candidates, SE3<S>()) < (std::is_same_v<S, float> ? 1e-2 : 1e-6));
}

TEMPLATE_TEST_CASE("p3p: degenerate input gives no pose and never NaN", "", float, double) {
  using S = TestType;
  Random random(3);
  const Problem<S> good = random_problem<S>(random);
  Problem<S> collinear = good;
  collinear.points_world[2] = S(0.3) * collinear.points_world[0] + S(0.7) * collinear.points_world[1];
  CHECK(p3p(collinear.bearings, collinear.points_world).empty());
  Problem<S> coincident = good;
  coincident.points_world[1] = coincident.points_world[0];
  CHECK(p3p(coincident.bearings, coincident.points_world).empty());
  Problem<S> same_bearing = good;
  same_bearing.bearings[1] = same_bearing.bearings[0];
  CHECK(p3p(same_bearing.bearings, same_bearing.points_world).empty());
  for (std::size_t i = 0; i < 3; ++i) {
    Problem<S> broken = good;
    broken.points_world[i].x() = std::numeric_limits<S>::quiet_NaN();
    CHECK(p3p(broken.bearings, broken.points_world).empty());
    broken = good;
    broken.bearings[i].y() = std::numeric_limits<S>::quiet_NaN();
    CHECK(p3p(broken.bearings, broken.points_world).empty());
  }
  for (int i = 0; i < 20000; ++i) {  // bearings and points that do not belong together
    Problem<S> nonsense;
    for (std::size_t k = 0; k < 3; ++k) {
      nonsense.bearings[k] = random_vector<S>(random).normalized();
      nonsense.points_world[k] = random_vector<S>(random) * S(std::pow(10, 3 * symmetric(random)));
    }
    for (const SE3<S>& T : p3p(nonsense.bearings, nonsense.points_world)) REQUIRE(T.is_finite());
  }
}
