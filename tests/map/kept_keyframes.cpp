#include "plumbline/map/kept_keyframes.hpp"

#include <cstddef>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/core/random.hpp"
#include "straight_places.hpp"

using namespace plumbline;
using test::along_x;

namespace {

using Places = test::StraightPlaces::Places;

/// Writes down which slots it is to forget.
struct Points {
  std::vector<int> forgotten;
  void forget(const Places::Keyframe&, int slot) { forgotten.push_back(slot); }
};
using Kept = KeptKeyframes<Places, Points>;

struct Run {
  std::unique_ptr<Kept> kept = std::make_unique<Kept>(PlaceGraphOptions{});
  Random random{1};

  void see(std::uint32_t sequence) {
    const SE3<double> T = along_x(sequence);
    Places::Keyframe* const keyframe = kept->begin(sequence, TimeNs(sequence), T, {}, test::isotropic(0.1));
    REQUIRE(keyframe);
    for (int n = 0; n < 4; ++n) {
      PlaceFeature feature;
      for (auto& word : feature.descriptor.words) word = random.next();
      feature.sigma_rad = 1e-3f;
      keyframe->features.push_back(feature);
    }
    kept->finish();
    REQUIRE(kept->retire(sequence, T) == keyframe);
  }
  std::vector<std::uint32_t> ids() const {
    std::vector<std::uint32_t> out;
    for (int k = 0; k < kept->places().size(); ++k) out.push_back(kept->places().keyframe(k).id);
    return out;
  }
  /// Whether the index has the keyframes that there are, and no others.
  bool has_index_of_all() {
    bool all = kept->index().size() == std::size_t(kept->places().size());
    for (int k = 0; k < kept->places().size(); ++k)
      all = all && kept->index().contains(std::uint32_t(kept->places().slot(k)));
    return all;
  }
  std::vector<std::byte> saved() const {
    std::vector<std::byte> out;
    kept->save([&](std::span<const std::byte> part) { out.insert(out.end(), part.begin(), part.end()); });
    return out;
  }
};

}  // namespace

TEST_CASE("kept_keyframes: one that is removed is removed everywhere") {
  Run run;
  for (const std::uint32_t sequence : {2u, 4u, 6u, 8u}) run.see(sequence);
  REQUIRE(run.has_index_of_all());
  const int slot = run.kept->places().slot(1);
  REQUIRE(run.kept->remove(1));
  CHECK(run.ids() == std::vector<std::uint32_t>{2, 6, 8});
  CHECK(run.has_index_of_all());
  CHECK(run.kept->points().forgotten == std::vector<int>{slot});
  run.see(10);  // in the slot that is free
  CHECK((run.kept->places().slot(3) == slot && run.has_index_of_all()));
}

TEST_CASE("kept_keyframes: the oldest of this run that has retired makes room, none of the map that was taken in") {
  Run before, run;
  for (const std::uint32_t sequence : {1u, 2u, 5u}) before.see(sequence);
  REQUIRE(run.kept->load(before.saved(), 10) == MapArchiveError::none);
  CHECK((run.kept->loaded() == 3 && run.has_index_of_all()));
  run.kept->remove_oldest();
  CHECK(run.ids() == std::vector<std::uint32_t>{1, 2, 5});
  for (const std::uint32_t sequence : {1u, 3u}) run.see(sequence);
  CHECK(run.ids() == std::vector<std::uint32_t>{1, 2, 5, 6, 8});  // ids of this run follow
  CHECK((run.kept->is_loaded(run.kept->places().keyframe(2)) && !run.kept->is_loaded(run.kept->places().keyframe(3))));
  run.kept->remove_oldest();
  CHECK(run.ids() == std::vector<std::uint32_t>{1, 2, 5, 8});
  CHECK(run.kept->retire(1, along_x(1)) == nullptr);  // no keyframe any more
}

TEST_CASE("kept_keyframes: the present world goes, the map that was taken in stays") {
  Run before, run;
  for (const std::uint32_t sequence : {1u, 2u}) before.see(sequence);
  REQUIRE(run.kept->load(before.saved(), 10) == MapArchiveError::none);
  for (const std::uint32_t sequence : {1u, 2u, 3u}) run.see(sequence);
  run.kept->remove_present_world();
  CHECK(run.ids() == std::vector<std::uint32_t>{1, 2});
  CHECK(run.has_index_of_all());
  CHECK(run.kept->points().forgotten.size() == 3);
}

TEST_CASE("kept_keyframes: a map without room for it is not taken in") {
  Run before, run;
  for (const std::uint32_t sequence : {1u, 2u, 5u}) before.see(sequence);
  CHECK(run.kept->load(before.saved(), 2) == MapArchiveError::no_room);
  CHECK((run.kept->loaded() == 0 && run.ids().empty() && run.kept->index().size() == 0));
  CHECK(run.kept->id_of(7) == 7);
  for (std::uint32_t sequence = 1; sequence <= 12; ++sequence) run.see(sequence);
  CHECK(run.kept->begin(13, 13, along_x(13), {}, test::isotropic(0.1)) == nullptr);
}

TEST_CASE("kept_keyframes: descriptors are those of the keyframe, in the order of its features") {
  Run run;
  run.see(1);
  const Places::Keyframe& keyframe = run.kept->places().keyframe(0);
  const auto descriptors = run.kept->descriptors_of(keyframe);
  REQUIRE(descriptors.size() == 4);
  for (std::size_t n = 0; n < 4; ++n) CHECK(descriptors[n].words == keyframe.features[n].descriptor.words);
}
