#include "plumbline/estimator/map_updates.hpp"

#include <string>

#include "catch.hpp"
#include "estimator/small_parts.hpp"

using namespace plumbline;
using test::SmallParts;

namespace {
/// Writes what it is told: k keyframe, r retired, c changed, x rejected, 0 reset.
struct Diary {
  std::string told;
  Diary(const auto&, const NoMap::Options&) {}
  void on_keyframe(const auto&) { told += 'k'; }
  void on_retired(const auto& frame) { told += 'r' + std::to_string(frame.sequence); }
  void on_world_change(const WorldChange<double>& change) {
    told += change.kind == WorldChange<double>::Kind::reset      ? '0'
            : change.kind == WorldChange<double>::Kind::rejected ? 'x'
                                                                 : 'c';
  }
  static void work() {}
  static Sim3<double> S_map_world() { return {}; }
};
using Updates = MapUpdates<SmallParts::Parts, Diary>;

struct Run : SmallParts {
  Updates updates{rig, NoMap::Options{}};
  int first, second;
  Run() {
    draw(0);
    const auto view = this->view(1);
    first = window->reset(view, {}, *tracker, rig_state);
    second = window->backend().insert(2, {}, {});
    for (const int slot : {second, first, first}) adopt(view, slot);
  }
  void adopt(const View<Sensors>& view, int slot) {
    updates.adopt(slot, window->frames(), window->landmarks(), view.current, view.depth, view.shutter, {},
                  identity<double, 6>());
  }
};
}  // namespace

TEST_CASE("map_updates: a keyframe is told once, also when it is adopted twice") {
  Run run;
  CHECK(run.updates.map().told == "kk");
}

TEST_CASE("map_updates: a reset hands the keyframes over first, the oldest one first, without a temporary frame") {
  Run run;
  const auto sequence = [&](int slot) { return 'r' + std::to_string(run.window->frames()[slot].sequence); };
  run.updates.map().told.clear();
  run.updates.reset(run.window->backend(), run.window->landmarks(), /*temporary=*/-1);
  CHECK(run.updates.map().told == sequence(run.first) + sequence(run.second) + "0");
  run.updates.map().told.clear();
  run.updates.reset(run.window->backend(), run.window->landmarks(), /*temporary=*/run.second);
  CHECK(run.updates.map().told == sequence(run.first) + "0");
}

TEST_CASE("map_updates: the keyframes of a rejected initialization are not handed over; those after it are") {
  Run run;
  run.updates.map().told.clear();
  run.updates.transform({}, {});
  run.updates.reject();
  run.updates.reset(run.window->backend(), run.window->landmarks(), -1);
  CHECK(run.updates.map().told == "cx0");
  run.updates.reset(run.window->backend(), run.window->landmarks(), -1);
  CHECK(run.updates.map().told.size() > 4);
}
