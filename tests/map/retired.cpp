// What a map gets when a frame leaves the window: the frame as it was estimated last, and the landmarks anchored in it.
#include "plumbline/map/retired.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <vector>

#include "catch.hpp"
#include "feature/seen_lines.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/propagation/constant_velocity.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/testing/simulated_points.hpp"

using namespace plumbline;

namespace {

constexpr int slots = 4, edges = 6;
constexpr double noise_scale = 0.1;

template <class S>
using Sensors = Rig<Rgbd<Pinhole<S>, 64 * 64>>;

/// A frame that a map keeps, with its landmarks in the world.
template <class S>
struct Remembered {
  struct Point {
    std::uint32_t id;
    Vec<S, 3> p_world;
    S sigma_inverse_range;
    Vec<float, 2> uv;
  };
  struct Line {
    std::uint32_t id;
    Plucker<S> world;
    LineSegment segment;
  };
  struct Seen {
    std::uint32_t id;
    bool is_point;
    Vec<float, 2> place;
  };
  std::uint32_t sequence;
  TimeNs t_ns;
  SE3<S> T_world_cam;
  std::vector<Point> points;
  std::vector<Line> lines;
  std::vector<Seen> others;
};

/// Keeps copies of all that it is given.
template <class S>
struct Memory {
  struct Edge {
    std::uint32_t a, b;
    Mat<S, 6, 6> covariance;
  };
  std::vector<Remembered<S>> frames;
  std::vector<Edge> edges;

  void on_retired(const auto& retired) {
    retired.for_each_neighbor([this](std::uint32_t a, std::uint32_t b, const auto& covariance) {
      edges.push_back({a, b, covariance});
    });
    Remembered<S> frame{retired.sequence, retired.t_ns, retired.x.T_world_body, {}, {}, {}};
    retired.for_each_landmark([&](const auto& landmark, const auto& seen) {
      using Kind = typename std::remove_cvref_t<decltype(landmark)>::Kind;
      if constexpr (std::is_same_v<typename Kind::Place, LineSegment>) {
        frame.lines.push_back({landmark.id, frame.T_world_cam * landmark.geometry.line.plucker(), seen.place()});
      } else {
        frame.points.push_back({landmark.id, frame.T_world_cam * Kind::middle(landmark.geometry),
                                landmark.geometry.sigma_inverse_range, seen.place()});
      }
    });
    retired.for_each_observation([&](std::uint32_t id, const auto& seen) {
      if constexpr (std::is_same_v<std::remove_cvref_t<decltype(seen.place())>, LineSegment>) {
        frame.others.push_back({id, false, seen.place().start});
      } else {
        frame.others.push_back({id, true, seen.place()});
      }
    });
    frames.push_back(frame);
  }
};

/// Keyframes that move sideways before points and edges, and a window that is solved for.
template <class S>
struct Run {
  using Landmarks = typename Features<Points<60>, Lines<16>>::template Landmarks<Sensors<S>, slots>;
  using Backend = WindowBackend<ConstantVelocity<Sensors<S>>, Landmarks, slots>;
  using LineStore = std::remove_reference_t<decltype(std::declval<Landmarks>().template get<1>())>;

  testing::SimulatedPoints points;
  std::vector<Vec<double, 3>> p_world, q_world;  ///< of edges
  testing::Gaussian noise;
  Sensors<S> rig{};
  std::unique_ptr<Landmarks> landmarks = std::make_unique<Landmarks>(StoreOptions{}, StoreOptions{});
  std::unique_ptr<Backend> backend = std::make_unique<Backend>(WindowOptions{}, ConstantVelocityOptions{});
  Memory<S> map;
  int keyframes = 0;

  explicit Run(std::uint64_t seed = 5) : noise(seed) {
    points.noise_scale = noise_scale;
    points.scatter(45, {1, 0.8, 0.8}, 1);
    rig.vision.camera = {S(460), S(460), S(319.5), S(239.5), {}};
    Random random(7);
    for (int i = 0; i < edges; ++i) {
      p_world.push_back(test::random_vector(random, 0.4) - Vec<double, 3>(0.5, 0, 0));
      q_world.push_back(p_world.back() + Vec<double, 3>(0.8, 0.3 * (i - 3), 0.1));
    }
  }

  static SE3<double> truth(int k) {
    return {SO3<double>::exp({0.01 * k, -0.03 * k, 0.02 * k}), Vec<double, 3>(0.1 * k, 0.03 * k, -3)};
  }
  TimeNs time(int k) const { return 1'000'000 * TimeNs(k) + 42; }

  int add_keyframe() {
    const SE3<double> T = truth(keyframes);
    const int slot = keyframes == 0 ? backend->start(time(0), {T.template cast<S>()})
                                    : backend->insert(time(keyframes), {T.template cast<S>()}, {});
    points.observe(landmarks->template get<0>(), T, slot, noise);
    observe_edges(landmarks->template get<1>(), T, slot);
    backend->optimize(rig, {}, *landmarks);
    ++keyframes;
    return slot;
  }
  /// Every other edge is new in the first keyframe, the rest in the second.
  void observe_edges(LineStore& store, const SE3<double>& T_world_cam, int slot) {
    using Observation = typename LineStore::Kind::Observation;
    const SE3<double> T = T_world_cam.inverse();
    const auto see = [&](std::uint32_t i) {
      return test::observe_segment<Observation>(points.camera, T * p_world[i], T * q_world[i], noise_scale, noise);
    };
    for (auto& landmark : store.landmarks()) landmark.current = see(landmark.id);
    store.record(slot);
    for (std::uint32_t i = 0; keyframes < 2 && i < edges; ++i) {
      if (int(i % 2) != keyframes) continue;
      typename LineStore::Landmark landmark;
      landmark.current = see(i);
      landmark.id = i;
      landmark.anchor = slot;
      landmark.observations[std::size_t(slot)] = landmark.current;
      landmark.geometry.line = Line3<double>::through(T * p_world[i], T * q_world[i]).template cast<S>();
      landmark.located = true;
      store.landmarks().push_back(landmark);
    }
  }
  void retire(int slot) { backend->retire(rig, {}, *landmarks, slot, map); }
};

}  // namespace

TEMPLATE_TEST_CASE("retired: a frame and the landmarks anchored in it, as they were estimated last", "", float,
                   double) {
  using S = TestType;
  Run<S> run;
  for (int k = 0; k < slots; ++k) run.add_keyframe();
  const auto& store = run.landmarks->template get<0>();
  const auto& lines = run.landmarks->template get<1>();
  const int slot = 0;
  std::vector<typename std::remove_cvref_t<decltype(store)>::Landmark> anchored;
  for (const auto& landmark : store.landmarks()) {
    if (landmark.anchor == slot) anchored.push_back(landmark);
  }
  const SE3<S> T = run.backend->window().T_world_body(slot);
  const std::uint32_t sequence = run.backend->window()[slot].sequence;
  const std::size_t edges_before = lines.landmarks().size();
  run.retire(slot);

  REQUIRE(run.map.frames.size() == 1);
  const Remembered<S>& frame = run.map.frames[0];
  CHECK(frame.sequence == sequence);
  CHECK(frame.t_ns == run.time(0));
  CHECK(minus(frame.T_world_cam, T).norm() == 0);
  REQUIRE(anchored.size() > 20);
  REQUIRE(frame.points.size() == anchored.size());
  for (std::size_t i = 0; i < anchored.size(); ++i) {
    const auto& point = frame.points[i];
    REQUIRE(point.id == anchored[i].id);
    CHECK(point.uv == anchored[i].observations[slot].pixel);
    CHECK(point.sigma_inverse_range == anchored[i].geometry.sigma_inverse_range);
    CHECK((point.p_world - T * Vec<S, 3>(anchored[i].geometry.bearing / anchored[i].geometry.inverse_range)).norm() <
          S(1e-5));
    CHECK((point.p_world.template cast<double>() - run.points.p_world[point.id]).norm() < 0.03);
  }
  REQUIRE(frame.lines.size() == edges / 2);
  for (const auto& line : frame.lines) {
    CHECK(line.id % 2 == 0);
    CHECK(line.segment.length() > 50);
    // The true edge is on it.
    const Plucker<double> L{line.world.n.template cast<double>(), line.world.v.template cast<double>()};
    CHECK((run.p_world[line.id].cross(L.v) - L.n).norm() < 0.02 * L.v.norm());
    CHECK((run.q_world[line.id].cross(L.v) - L.n).norm() < 0.02 * L.v.norm());
  }
  // They are no longer in the window, but in the map.
  for (const auto& landmark : store.landmarks()) REQUIRE(landmark.anchor != slot);
  CHECK(lines.landmarks().size() == edges_before - edges / 2);
}

TEMPLATE_TEST_CASE("retired: what else the frame saw, by the ids of landmarks that stay", "", float, double) {
  using S = TestType;
  Run<S> run;
  for (int k = 0; k < slots; ++k) run.add_keyframe();
  const int slot = 3;  // the newest: all that it sees is anchored before it
  std::vector<typename Remembered<S>::Seen> expected;
  run.landmarks->for_each([&](const auto& store) {
    for (const auto& landmark : store.landmarks()) {
      const auto& seen = landmark.observations[slot];
      if (landmark.anchor == slot || !seen.valid) continue;
      if constexpr (std::is_same_v<std::remove_cvref_t<decltype(seen.place())>, LineSegment>) {
        expected.push_back({landmark.id, false, seen.segment.start});
      } else {
        expected.push_back({landmark.id, true, seen.pixel});
      }
    }
  });
  run.retire(slot);
  REQUIRE(run.map.frames.size() == 1);
  const auto& others = run.map.frames[0].others;
  REQUIRE(others.size() == expected.size());
  REQUIRE(others.size() > 20);
  int lines = 0;
  for (std::size_t i = 0; i < others.size(); ++i) {
    CHECK(others[i].id == expected[i].id);
    CHECK(others[i].is_point == expected[i].is_point);
    CHECK(others[i].place == expected[i].place);
    lines += !others[i].is_point;
  }
  CHECK(lines == edges);
}

TEST_CASE("retired: landmarks that were never located are dropped") {
  Run<double> run;
  for (int k = 0; k < slots; ++k) run.add_keyframe();
  auto& landmarks = run.landmarks->get<0>().landmarks();
  std::uint32_t id = 0;
  for (auto& landmark : landmarks) {
    if (landmark.anchor != 0) continue;
    id = landmark.id;
    landmark.located = false;
    break;
  }
  run.retire(0);
  for (const auto& point : run.map.frames[0].points) CHECK(point.id != id);
  for (const auto& seen : run.map.frames[0].others) CHECK_FALSE((seen.is_point && seen.id == id));
}

TEST_CASE("retired: a map gets every frame once, in the order of marginalization") {
  Run<double> run;
  for (int k = 0; k < 12; ++k) {
    if (run.backend->window().full()) run.retire(run.backend->window().oldest());
    run.add_keyframe();
  }
  REQUIRE(run.map.frames.size() == 12 - slots);
  for (std::size_t k = 0; k < run.map.frames.size(); ++k) {
    CHECK(run.map.frames[k].sequence == k + 1);
    CHECK(run.map.frames[k].t_ns == run.time(int(k)));
    CHECK(minus(run.map.frames[k].T_world_cam, run.truth(int(k))).norm() < 0.02);
  }
}

TEMPLATE_TEST_CASE("retired: the window knows how certain the motion to its neighbors is", "", float, double) {
  using S = TestType;
  double nees = 0;
  constexpr int runs = 60;
  for (int seed = 0; seed < runs; ++seed) {
    Run<S> run(std::uint64_t(100 + seed));
    for (int k = 0; k < slots; ++k) run.add_keyframe();
    const SE3<double> T_0 = run.backend->window().T_world_body(0).template cast<double>(),
                      T_1 = run.backend->window().T_world_body(1).template cast<double>();
    run.retire(0);
    REQUIRE(run.map.edges.size() == 1);  // nothing is before it
    const auto& edge = run.map.edges[0];
    CHECK(edge.a + 1 == edge.b);
    const Vec<double, 6> error = minus(run.truth(0).inverse() * run.truth(1), T_0.inverse() * T_1);
    const Mat<double, 6, 6> P = edge.covariance.template cast<double>();
    nees += error.dot(P.llt().solve(error)) / (runs * noise_scale * noise_scale);  // of the noise that sigmas claim
    CHECK(P.trace() < 1e-3);
  }
  CHECK(nees > 3.5);
  CHECK(nees < 8.5);  // 6 expected
}

TEST_CASE("retired: a frame in the middle has two neighbors") {
  Run<double> run;
  for (int k = 0; k < slots; ++k) run.add_keyframe();
  run.retire(2);
  REQUIRE(run.map.edges.size() == 2);
  CHECK(run.map.edges[0].a == 2);
  CHECK(run.map.edges[0].b == 3);
  CHECK(run.map.edges[1].a == 3);
  CHECK(run.map.edges[1].b == 4);
}
