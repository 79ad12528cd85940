#include "plumbline/io/trajectory_alignment.hpp"

#include <vector>

#include "catch.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;
using namespace plumbline::io;

namespace {

/// Pairs whose reference is the similarity of the estimate, on a plane if `flat`.
std::vector<PosePair> pairs_related_by(const Sim3<double>& truth, bool flat) {
  Random random(7);
  const auto coordinate = [&] { return 2 * random.uniform() - 1; };
  std::vector<PosePair> pairs;
  for (int i = 0; i < 50; ++i) {
    const Vec<double, 3> p(coordinate(), coordinate(), flat ? 0 : coordinate()),
        phi(coordinate(), coordinate(), coordinate());
    const SE3<double> estimate(SO3<double>::exp(phi), p);
    pairs.push_back({i, aligned(truth, estimate), estimate});
  }
  return pairs;
}

double difference(const Sim3<double>& a, const Sim3<double>& b) { return (a.inverse() * b).log().norm(); }

}  // namespace

TEST_CASE("trajectory_alignment: the similarity is found again") {
  const Sim3<double> truth(2.5, SO3<double>::exp({0.4, -1.1, 2}), {3, -4, 5});
  for (const bool flat : {false, true})
    REQUIRE(difference(*align(pairs_related_by(truth, flat), Alignment::sim3), truth) < 1e-12);
}

TEST_CASE("trajectory_alignment: a rigid one has scale 1, one about gravity only yaw") {
  const Sim3<double> rigid(1, SO3<double>::exp({0.4, -1.1, 2}), {3, -4, 5});
  REQUIRE(difference(*align(pairs_related_by(rigid, false), Alignment::se3), rigid) < 1e-12);
  const Sim3<double> yaw(1, SO3<double>::exp({0, 0, -2.7}), {3, -4, 5});
  REQUIRE(difference(*align(pairs_related_by(yaw, false), Alignment::posyaw), yaw) < 1e-12);
  REQUIRE(align(pairs_related_by(rigid, false), Alignment::posyaw)->rotation().log().head<2>().norm() < 1e-12);
  REQUIRE(difference(*align(pairs_related_by(rigid, false), Alignment::none), Sim3<double>()) == 0);
}

TEST_CASE("trajectory_alignment: nothing to align by") {
  const std::vector<PosePair> two(2), still(10);
  REQUIRE(!align(two, Alignment::se3));
  REQUIRE(!align(still, Alignment::sim3));
  std::vector<PosePair> line;
  line.reserve(10);
  for (int i = 0; i < 10; ++i) line.push_back({i, SE3<double>({}, {1.0 * i, 0, 0}), SE3<double>({}, {0, 1.0 * i, 0})});
  REQUIRE(!align(line, Alignment::se3));
  REQUIRE(align(two, Alignment::none));
}

TEST_CASE("trajectory_alignment: names") {
  REQUIRE((alignment_named("posyaw") == Alignment::posyaw && !alignment_named("se4")));
}

TEST_CASE("trajectory_alignment: pairs in order of the estimate") {
  const auto at = [](TimeNs t_ns, double x) { return StampedPose{t_ns, SE3<double>({}, {x, 0, 0})}; };
  const Trajectory reference{at(0, 0), at(5'000'000, 1), at(10'000'000, 2), at(90'000'000, 3)},
      estimate{at(6'000'000, 10), at(50'000'000, 20)};
  const std::vector<PosePair> pairs = associate(reference, estimate, 0.02);
  REQUIRE((pairs.size() == 1 && pairs[0].reference.p().x() == 1 && pairs[0].estimate.p().x() == 10));
}
