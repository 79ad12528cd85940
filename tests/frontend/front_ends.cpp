// The front ends of all kinds: order of the calls, by scripted ones; the pose of the consensus, by rendered frames.
#include "plumbline/frontend/front_ends.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <type_traits>

#include "catch.hpp"
#include "estimator/simulation.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/frontend/flow.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/state/frame_window.hpp"

using namespace plumbline;
using test::SimulatedRgbd;

namespace {

template <class S>
using RigOf = Rig<Rgbd<Pinhole<S>, SimulatedRgbd::width * SimulatedRgbd::height>>;
template <class S>
using Window = FrameWindow<S, VisualLayout, 3>;

// --------------------------------------------------------------------------------------------------- scripted

/// What front ends were asked, in order.
std::string& script() {
  static std::string text;
  return text;
}
std::string played(auto&& play) {
  script().clear();
  play();
  return script();
}

/// Notes that it was asked, under a letter of its own.
template <class Store, char name>
struct Scripted {
  struct Options {
    int number = 0;
  };
  static constexpr bool gives_correspondences = false;

  explicit Scripted(const Options& options) : number(options.number) {}
  void follow(const auto&, const auto&, Store&, const auto&) { note("f"); }
  void refine(const auto&, const auto&, Store&, const auto&) { note("r"); }
  void locate(const auto&, const auto&, Store&, const auto&) { note("l"); }
  void detect(const auto&, const auto&, Store&, int) { note("d"); }

  static void note(const char* what) { script() += std::string(1, name) + what + " "; }
  int number;
};
/// For initialization alone, and it relates two views.
template <class Store>
struct Starting : Scripted<Store, 's'> {
  using Scripted<Store, 's'>::Scripted;
  static constexpr bool is_for_initialization = true, relates_two_views = true;
  void begin_initialization() { this->note("b"); }
  void end_initialization(Store& store) {
    store.clear();
    this->note("e");
  }
  void for_each_pair(const auto&, const Store&, int slot, auto&& visit) const { visit(slot, slot + 1); }
};
/// Reads the stores of the kinds named before it.
template <class Store>
struct ReadsKindsBefore : Scripted<Store, 'c'> {
  using Scripted<Store, 'c'>::Scripted;
  static constexpr bool reads_kinds_before = true;
  template <class... Before>
  void follow(const auto&, const auto&, Store&, const auto&, const std::tuple<Before...>& before) {
    this->note("f");
    script() +=
        std::to_string(std::apply([](const auto&... store) { return (0 + ... + store.capacity); }, before)) + " ";
  }
  void refine(const auto&, const auto&, Store&, const auto&, const auto&) { this->note("r"); }
  void locate(const auto&, const auto&, Store&, const auto&, const auto&) { this->note("l"); }
  void detect(const auto&, const auto&, Store&, int, const auto&) { this->note("d"); }
};

struct First : Points<8> {
  template <class Options>
  struct Named {
    Options first;
  };
  static auto& options_of(auto& all) { return all.first; }
};
struct Second : Points<16> {
  template <class Options>
  struct Named {
    Options second;
  };
  static auto& options_of(auto& all) { return all.second; }
};
struct Third : Points<32> {
  template <class Options>
  struct Named {
    Options third;
  };
  static auto& options_of(auto& all) { return all.third; }
};

struct Script {
  template <class E, class Store>
  struct Which;
  template <class Store>
  struct Which<First, Store> {
    using Type = Scripted<Store, 'a'>;
  };
  template <class Store>
  struct Which<Second, Store> {
    using Type = Starting<Store>;
  };
  template <class Store>
  struct Which<Third, Store> {
    using Type = ReadsKindsBefore<Store>;
  };
  template <class E, class Store>
  using Of = typename Which<E, Store>::Type;
};

using Sensors = RigOf<float>;
using Ends = FrontEnds<Script, Sensors, 3, Features<First, Second, Third>>;

struct Stage {
  Sensors rig{};
  std::unique_ptr<RigPyramid<Sensors>> pyramid = std::make_unique<RigPyramid<Sensors>>();
  View<Sensors> view{0, 0.1f, rig, *pyramid, *pyramid, {}, {}, {}, {rig.vision.camera, 240, 0.0f}};
  Window<float> window;
  Ends::Options options;
  Ends front_ends{options};
  std::unique_ptr<Ends::Landmarks> landmarks{new Ends::Landmarks(Ends::make_landmarks(options))};
};

}  // namespace

static_assert(Ends::relates_two_views);
static_assert(!FrontEnds<Script, Sensors, 3, Features<First, Third>>::relates_two_views);

TEST_CASE("front_ends: kinds are asked in order; one that reads the kinds before it is given their stores") {
  Stage stage;
  const SE3<float> I;
  Ends& front_ends = stage.front_ends;
  Ends::Landmarks& landmarks = *stage.landmarks;
  const View<Sensors>& view = stage.view;
  const Window<float>& window = stage.window;
  REQUIRE(played([&] { front_ends.follow(view, window, landmarks, I); }) == "af sf cf 24 ");
  REQUIRE(played([&] { front_ends.refine(view, window, landmarks, I); }) == "ar sr cr ");
  REQUIRE(played([&] { front_ends.locate(view, window, landmarks, I); }) == "al sl cl ");
  REQUIRE(played([&] { front_ends.detect(view, window, landmarks, 1); }) == "ad sd cd ");
  SE3<float> T;
  REQUIRE(front_ends.find_consensus(view, window, landmarks, {}, T).candidates == 0);  // none gives correspondences
  REQUIRE(T.log().norm() == 0);
}

TEST_CASE("front_ends: an initialization uses the kinds that take part in it") {
  Stage stage;
  for (int k = 0; k < 3; ++k) {
    Ends::Landmarks& all = *stage.landmarks;
    all.for_each([](auto& store) {
      typename std::remove_cvref_t<decltype(store)>::Landmark landmark;
      landmark.located = landmark.current.valid = true;
      REQUIRE(store.add(landmark, 0));
    });
  }
  REQUIRE(stage.front_ends.lasting_count(*stage.landmarks) == 6);  // not those of the start
  REQUIRE(played([&] { stage.front_ends.begin_initialization(); }) == "sb ");
  int pairs = 0;
  stage.front_ends.for_each_pair(stage.view, *stage.landmarks, 2, [&](int then, int now) {
    REQUIRE(then == 2);
    REQUIRE(now == 3);
    ++pairs;
  });
  REQUIRE(pairs == 1);
  REQUIRE(played([&] { stage.front_ends.end_initialization(*stage.landmarks); }) == "se ");
  REQUIRE(stage.landmarks->get<1>().landmarks().empty());
  REQUIRE(stage.landmarks->get<0>().landmarks().size() == 3);
}

TEST_CASE("front_ends: stores begin a frame, record keyframes and drop useless landmarks") {
  Stage stage;
  auto& store = stage.landmarks->get<0>();
  typename std::remove_cvref_t<decltype(store)>::Landmark landmark;
  landmark.current.valid = true;
  REQUIRE(store.add(landmark, 0));
  store.landmarks()[0].previous.valid = false;
  stage.front_ends.follow(stage.view, stage.window, *stage.landmarks, {});
  REQUIRE(store.landmarks()[0].previous.valid);
  stage.front_ends.detect(stage.view, stage.window, *stage.landmarks, 2);
  REQUIRE(store.landmarks()[0].observations[2].valid);
  store.landmarks()[0].current.valid = false;
  stage.front_ends.locate(stage.view, stage.window, *stage.landmarks, {});
  REQUIRE(store.landmarks().empty());  // lost before it was known
}

TEST_CASE("front_ends: every kind has its options under its name, those of store and front end side by side") {
  Ends::Options options;
  options.first.number = 1;
  options.third.number = 3;
  options.third.max_misses = 0;
  REQUIRE(Ends::Of<First>(First::options_of(options)).number == 1);
  REQUIRE(Ends::Of<Second>(Second::options_of(options)).number == 0);
  REQUIRE(Ends::Of<Third>(Third::options_of(options)).number == 3);
  const std::unique_ptr<Ends::Landmarks> landmarks{new Ends::Landmarks(Ends::make_landmarks(options))};
  auto& store = landmarks->get<2>();
  typename std::remove_cvref_t<decltype(store)>::Landmark landmark;
  landmark.located = landmark.current.valid = true;
  landmark.misses = 1;
  REQUIRE(store.add(landmark, 0));
  for (auto& seen : store.landmarks()[0].observations) seen.valid = true;
  store.landmarks()[0].current.valid = false;
  store.prune();
  REQUIRE(store.landmarks().empty());
}

// --------------------------------------------------------------------------------------------------- rendered

TEMPLATE_TEST_CASE("front_ends: outliers are removed from the frame, the pose is right", "", float, double) {
  using S = TestType;
  using Room = RigOf<S>;
  using Followed = FrontEnds<Flow, Room, 3, Features<Points<250>, Lines<20>>>;
  static const SimulatedRgbd room(3);
  const auto T = [&](int i) { return room.T_world_cam[std::size_t(i)].template cast<S>(); };
  Room rig{};
  rig.vision.camera = {S(room.camera.fx), S(room.camera.fy), S(room.camera.cx), S(room.camera.cy), {}};
  rig.vision.width = SimulatedRgbd::width;
  rig.vision.height = SimulatedRgbd::height;
  const auto pyramids = std::make_unique<std::array<RigPyramid<Room>, 2>>();
  const auto view = [&](int i) -> View<Room> {
    REQUIRE((*pyramids)[std::size_t(i % 2)].build(room.frames[std::size_t(i)].gray.view()));
    return {room.t_ns[std::size_t(i)],
            S(0.05),
            rig,
            (*pyramids)[std::size_t(1 - i % 2)],
            (*pyramids)[std::size_t(i % 2)],
            room.frames[std::size_t(i)].depth.view(),
            T(std::max(i - 1, 0)),
            SE3<S>(),
            {rig.vision.camera, rig.vision.height, S(0)}};
  };
  const typename Followed::Options options;
  const auto front_ends = std::make_unique<Followed>(options);
  const std::unique_ptr<typename Followed::Landmarks> all{
      new typename Followed::Landmarks(Followed::make_landmarks(options))};
  Window<S> window;
  front_ends->detect(view(0), window, *all, window.insert(0, {T(0)}));
  const View<Room> now = view(1);
  front_ends->follow(now, window, *all, T(1));
  auto& store = all->template get<0>();
  auto& landmarks = store.landmarks();
  const int lines = all->template get<1>().seen_count();
  REQUIRE(lines > 5);
  for (std::size_t i = 0; i < landmarks.size(); i += 4) landmarks[i].current.uv.x() += i % 8 == 0 ? 25 : -25;
  SE3<S> T_found = plus(T(1), (Vec<S, 6>() << S(0.01), S(-0.01), S(0.02), S(0.03), S(0.02), S(-0.03)).finished());
  front_ends->find_consensus(now, window, *all, PoseRansacOptions{}, T_found);
  REQUIRE(minus(T_found, T(1)).template tail<3>().norm() < S(0.03));
  std::set<std::uint32_t> rejected;
  for (const auto& each : store.rejected()) rejected.insert(each.id);
  for (std::size_t i = 0; i < landmarks.size(); i += 4) {
    if (landmarks[i].located) REQUIRE_FALSE(landmarks[i].current.valid);
  }
  for (const auto& landmark : landmarks) {
    if (rejected.contains(landmark.id)) REQUIRE_FALSE(landmark.current.valid);
  }
  REQUIRE(rejected.size() > landmarks.size() / 8);
  REQUIRE(store.tracked_count() > int(landmarks.size()) / 2);
  REQUIRE(all->template get<1>().seen_count() == lines);  // they give no correspondences
  REQUIRE(front_ends->lasting_count(*all) == store.tracked_count() + all->template get<1>().tracked_count());
  front_ends->follow(view(2), window, *all, T(2));
  REQUIRE(store.rejected().empty());

  // Where the gate excludes all poses, one is found all the same.
  SE3<S> T_other = T_found;
  front_ends->find_consensus(view(2), window, *all, PoseRansacOptions{}, T_other, [](const SE3<S>&) { return false; });
  REQUIRE(minus(T_other, T_found).norm() > 0);
  // The gate is called for poses.
  int asked = 0;
  front_ends->follow(view(2), window, *all, T_found);
  front_ends->find_consensus(view(2), window, *all, PoseRansacOptions{}, T_other,
                             [&](const SE3<S>&) { return ++asked > 0; });
  REQUIRE(asked > 0);

  store.clear();  // no correspondences are left
  const SE3<S> before = T_found;
  front_ends->find_consensus(view(2), window, *all, PoseRansacOptions{}, T_found);
  REQUIRE(minus(before, T_found).norm() == 0);
}
