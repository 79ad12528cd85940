// What an estimator does not have takes no memory: no IMU, no depth, no rolling shutter, no lines, no factors, no map.
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/core/present.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/collinear.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/map/no_map.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/state/rig_state.hpp"

using namespace plumbline;

namespace {

using S = float;
using Camera = Pinhole<S>;
constexpr std::size_t max_pixels = 160 * 128;
constexpr int slots = 5;

template <bool imu, bool depth, bool rolls>
using RigOf = Rig<std::conditional_t<depth, Rgbd<Camera, max_pixels, std::conditional_t<rolls, Rolling, Global>>,
                                     Mono<Camera, max_pixels, std::conditional_t<rolls, Rolling, Global>>>,
                  std::conditional_t<imu, Imu, NoImu>>;
template <bool lines>
using FeaturesOf = std::conditional_t<lines, Features<Points<60>, Lines<30>>, Features<Points<60>>>;

template <bool imu, bool depth, bool rolls, bool lines>
using PartsOf = Composition<RigOf<imu, depth, rolls>, FeaturesOf<lines>, SlidingWindow<slots>>;
template <bool imu, bool depth, bool rolls, bool lines>
using VioOf = Estimator<RigOf<imu, depth, rolls>, FeaturesOf<lines>, SlidingWindow<slots>>;

template <bool imu, bool depth, bool rolls, bool lines>
constexpr std::size_t size = sizeof(VioOf<imu, depth, rolls, lines>);

/// visit<imu, depth, rolls, lines>() of all sixteen.
void for_each_combination(auto&& visit) {
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    (visit.template operator()<(I & 8) != 0, (I & 4) != 0, (I & 2) != 0, (I & 1) != 0>(), ...);
  }
  (std::make_index_sequence<16>{});
}

/// A map that counts what it is given. Its bytes are so many that what comes after it keeps its alignment.
struct CountingMap {
  struct Options {};
  struct Counter {
    int retired = 0, landmarks = 0;
    std::array<std::byte, 4096 - 2 * sizeof(int)> bytes{};

    Counter(const auto& /*rig*/, const auto& /*options*/) {}
    static void on_keyframe(const auto& /*keyframe*/) {}
    static void on_world_change(const auto& /*change*/) {}
    void on_retired(const auto& frame) {
      ++retired;
      frame.for_each_landmark([&](const auto&, const auto&) { ++landmarks; });
    }
    static void work() {}
    static Sim3<S> S_map_world() { return {}; }
  };
  template <class Parts>
  using Map = Counter;
};

/// Bigger by nothing when it is absent, wherever it stands.
template <class Absent>
struct WithAbsent {
  float value;
  [[no_unique_address]] Absent absent;
};
template <class Absent>
constexpr bool is_free = std::is_empty_v<Absent> && sizeof(WithAbsent<Absent>) == sizeof(float);

}  // namespace

TEST_CASE("absence: what stands for nothing is an empty type of its own") {
  STATIC_REQUIRE(is_free<NoImu>);
  STATIC_REQUIRE(is_free<NoFactors>);
  STATIC_REQUIRE(is_free<NoFactor>);
  STATIC_REQUIRE(is_free<NoMap::Discard<S>>);
  STATIC_REQUIRE(is_free<Present<Readout<S>, false>>);
  STATIC_REQUIRE(is_free<Present<InverseDepth<S>, false>>);
  STATIC_REQUIRE(is_free<Present<Vec<S, 3>, false>>);
  STATIC_REQUIRE(is_free<DepthInitializer<S>>);
  STATIC_REQUIRE(is_free<LandmarkTies<PartsOf<false, false, false, false>::Landmarks>>);
  STATIC_REQUIRE(is_free<LandmarkTies<PartsOf<true, true, true, true>::Landmarks>>);
}

TEST_CASE("absence: a rig is its camera and two numbers") {
  STATIC_REQUIRE(sizeof(RigOf<false, false, false>) == sizeof(Camera) + 2 * sizeof(int));
  STATIC_REQUIRE(sizeof(RigOf<false, false, true>) == sizeof(RigOf<false, false, false>) + sizeof(Readout<S>));
  STATIC_REQUIRE(sizeof(RigOf<false, true, false>) == sizeof(RigOf<false, false, false>) + sizeof(DepthSensor<S>));
  STATIC_REQUIRE(sizeof(RigState<RigOf<false, false, false>>) == sizeof(SE3<S>));
}

TEST_CASE("absence: a landmark of a global shutter without depth is its geometry, its pixel and the weight of it") {
  using Bare = PointKind<RigOf<false, false, false>>;
  using Deep = PointKind<RigOf<false, true, false>>;
  using Rolled = PointKind<RigOf<false, false, true>>;
  STATIC_REQUIRE(sizeof(Bare::Geometry) == 5 * sizeof(S));
  STATIC_REQUIRE(sizeof(Rolled::Geometry) == sizeof(Bare::Geometry) + sizeof(RowDerivative<S, 3>));
  struct Seen {
    bool valid;
    Vec<float, 2> pixel, uv;
    Mat<float, 2, 2> L;
  };
  STATIC_REQUIRE(sizeof(Bare::Observation) == sizeof(Seen));
  STATIC_REQUIRE(sizeof(Deep::Observation) > sizeof(Seen));
  STATIC_REQUIRE(sizeof(Rolled::Observation) > sizeof(Seen));
  STATIC_REQUIRE((Bare::rows_per_view == 2 && Deep::rows_per_view == 3));

  using BareLine = LineKind<RigOf<false, false, false>>;
  using DeepLine = LineKind<RigOf<false, true, false>>;
  using RolledLine = LineKind<RigOf<false, false, true>>;
  STATIC_REQUIRE(sizeof(DeepLine::Observation) - sizeof(BareLine::Observation) >=
                 sizeof(SegmentMeasurement<LineInverseDepth<S>>));
  STATIC_REQUIRE(sizeof(RolledLine::Observation) - sizeof(BareLine::Observation) >= sizeof(Mat<S, 3, 2>));
  STATIC_REQUIRE((BareLine::rows_per_view == 2 && DeepLine::rows_per_view == 4));
}

TEST_CASE("absence: a frame of a camera alone is a pose, and a window of them has nothing else") {
  using Bare = PartsOf<false, false, false, false>;
  using Inertial = PartsOf<true, false, false, false>;
  STATIC_REQUIRE(Bare::Backend::Layout::dim == 6);
  STATIC_REQUIRE(Inertial::Backend::Layout::dim == 15);
  STATIC_REQUIRE(sizeof(FrameState<S, VisualLayout>) == sizeof(Estimated<state::Pose, S>));
  // The equations of the window alone grow by the squares of 6 and 15.
  STATIC_REQUIRE(sizeof(Inertial::Backend) - sizeof(Bare::Backend) >
                 sizeof(double) * (15 * 15 - 6 * 6) * slots * slots + sizeof(ImuFactors<S, slots>));
  STATIC_REQUIRE(sizeof(Inertial::Propagation) - sizeof(Bare::Propagation) > sizeof(ImuBuffer<>));
  STATIC_REQUIRE(sizeof(Bare::Propagation) <= 64);
}

TEST_CASE("absence: an estimator without lines lacks at least their store, their front end and their terms") {
  for_each_combination([]<bool imu, bool depth, bool rolls, bool lines>() {
    if constexpr (lines) {
      using Parts = PartsOf<imu, depth, rolls, true>;
      using Store = std::remove_cvref_t<decltype(std::declval<typename Parts::Landmarks>().template get<1>())>;
      using FrontEnd = typename Parts::FrontEnds::template Of<Lines<30>>;
      constexpr std::size_t of_lines = sizeof(Store) + sizeof(FrontEnd) + sizeof(WindowTerms<Store>);
      STATIC_REQUIRE(size<imu, depth, rolls, true> - size<imu, depth, rolls, false> >= of_lines);
    }
  });
}

TEST_CASE("absence: collinear features are their store, their front end, their terms and the ties to points") {
  using Sensors = RigOf<true, false, true>;
  using Parts = Composition<Sensors, Features<Points<60>, Collinear<30>>, SlidingWindow<slots>>;
  using Points = std::remove_cvref_t<decltype(std::declval<Parts::Landmarks>().get<0>())>;
  using Store = std::remove_cvref_t<decltype(std::declval<Parts::Landmarks>().get<1>())>;
  constexpr std::size_t of_collinear = sizeof(Store) + sizeof(Parts::FrontEnds::Of<Collinear<30>>) +
                                       sizeof(WindowTerms<Store>) + sizeof(CollinearTerms<Store, Points>);
  constexpr std::size_t with =
      sizeof(Estimator<Sensors, Features<plumbline::Points<60>, Collinear<30>>, SlidingWindow<slots>>);
  constexpr std::size_t without = size<true, false, true, false>;
  std::printf("collinear: %zu bytes more than points alone\n", with - without);
  STATIC_REQUIRE(with - without >= of_collinear);
  // Nothing of a line's looks is kept, and no depth but that of the points.
  STATIC_REQUIRE(sizeof(CollinearKind<RigOf<false, true, false>>::Observation) <
                 sizeof(LineKind<RigOf<false, false, false>>::Observation));
}

TEST_CASE("absence: whatever is left out makes an estimator smaller, whatever else it has") {
  std::printf("%-10s %-10s %-10s %-10s %10s\n", "IMU", "depth", "shutter", "lines", "bytes");
  for_each_combination([]<bool imu, bool depth, bool rolls, bool lines>() {
    constexpr std::size_t bytes = size<imu, depth, rolls, lines>;
    std::printf("%-10s %-10s %-10s %-10s %10zu\n", imu ? "yes" : "no", depth ? "yes" : "no",
                rolls ? "rolling" : "global", lines ? "yes" : "no", bytes);
    if constexpr (imu) STATIC_REQUIRE(bytes > size<false, depth, rolls, lines>);
    if constexpr (rolls) STATIC_REQUIRE(bytes > size<imu, depth, false, lines>);
    if constexpr (lines) STATIC_REQUIRE(bytes > size<imu, depth, rolls, false>);
  });
}

TEST_CASE("absence: depth in every observation is gone with the sensor, the start by two views comes instead") {
  for_each_combination([]<bool imu, bool depth, bool rolls, bool lines>() {
    if constexpr (depth) {
      using With = PartsOf<imu, true, rolls, lines>;
      using Without = PartsOf<imu, false, rolls, lines>;
      STATIC_REQUIRE(sizeof(typename With::Landmarks) - sizeof(typename Without::Landmarks) >=
                     60 * (slots + 2) * sizeof(InverseDepth<S>));
      STATIC_REQUIRE(sizeof(typename With::Backend) > sizeof(typename Without::Backend));
      STATIC_REQUIRE(sizeof(typename With::Initializer) < sizeof(typename Without::Initializer));
    }
  });
}

TEST_CASE("absence: an estimator is the sum of its parts, and a map that keeps nothing is none of them") {
  for_each_combination([]<bool imu, bool depth, bool rolls, bool lines>() {
    using Parts = PartsOf<imu, depth, rolls, lines>;
    using Vio = VioOf<imu, depth, rolls, lines>;
    using Discard = NoMap::Discard<S>;
    constexpr std::size_t parts =
        sizeof(typename Parts::Sensors) + sizeof(RigState<typename Parts::Sensors>) + sizeof(FrameTracker<Parts>) +
        sizeof(typename Parts::Landmarks) + sizeof(typename Parts::Backend) + sizeof(typename Parts::Propagation) +
        sizeof(Initialization<Parts>) + sizeof(Navigation<S, typename Parts::Propagation::Layout>) +
        sizeof(Outage<Parts, Discard>) + sizeof(Publisher<S>) + sizeof(FrameTiming);
    STATIC_REQUIRE(sizeof(Vio) <= parts + 512);  // alignment, the keyframe's covariance, some counters
    // To the byte, with a map that keeps every alignment.
    using WithMap = Estimator<RigOf<imu, depth, rolls>, FeaturesOf<lines>, SlidingWindow<slots>, NoClock, CountingMap>;
    STATIC_REQUIRE(sizeof(WithMap) == sizeof(Vio) + sizeof(CountingMap::Counter));
  });
}

TEST_CASE("absence: a map that is there gets every frame that leaves, and its bytes are the estimator's") {
  using Vo = Estimator<RigOf<false, true, false>, FeaturesOf<false>, SlidingWindow<slots>, NoClock, CountingMap>;
  RigOf<false, true, false> rig{};
  rig.vision.camera = {130, 130, 79.5f, 63.5f, {}};
  rig.vision.width = 160;
  rig.vision.height = 128;
  const auto vo = std::make_unique<Vo>(rig);
  const auto* const map = &vo->map();
  const auto address = [](const auto* x) { return reinterpret_cast<std::uintptr_t>(x); };
  REQUIRE(address(map) >= address(vo.get()));
  REQUIRE(address(map) + sizeof(*map) <= address(vo.get()) + sizeof(Vo));

  // The camera goes to the left before a wall of squares, 6 px of the image a frame.
  std::array<std::uint8_t, 160 * 128> gray;
  std::array<std::uint16_t, 160 * 128> depth;
  depth.fill(2000);
  int keyframes = 0;
  for (int i = 0; i < 60; ++i) {
    for (int y = 0; y < 128; ++y) {
      for (int x = 0; x < 160; ++x) {
        const std::uint32_t square =
            std::uint32_t((6 * i + 159 - x) / 9) * 73856093u ^ std::uint32_t(y / 9) * 19349663u;
        gray[std::size_t(y * 160 + x)] = std::uint8_t(30 + (square * 2654435761u >> 24) * 3 / 4);
      }
    }
    const TimeNs t_ns = TimeNs(50'000'000) * (i + 1);
    const Result<Estimate<S>> estimate =
        vo->add_frame({t_ns, {gray.data(), 160, 128, 160}, {depth.data(), 160, 128, 160}});
    REQUIRE(estimate);
    CAPTURE(i);
    REQUIRE((estimate->health.state == HealthState::tracking ||
             estimate->health.reason == HealthReason::few_features));  // so small an image may have few
    keyframes += estimate->keyframe;
    const auto& window = vo->backend().window();
    REQUIRE(map->retired + window.size() == keyframes);
  }
  CAPTURE(keyframes);
  REQUIRE(map->retired >= 5);
  REQUIRE(map->landmarks > 0);
}
