// A saved map: what is restored is what was saved; damaged bytes change nothing; a run finds itself in it.
#include "plumbline/map/map_archive.hpp"

#include <memory>
#include <vector>

#include "catch.hpp"
#include "laps.hpp"

using namespace plumbline;
using test::Laps;
using test::per_lap;

namespace {

template <class Map>
std::vector<std::byte> saved(const Map& map) {
  std::vector<std::byte> bytes;
  map.save([&](std::span<const std::byte> part) { bytes.insert(bytes.end(), part.begin(), part.end()); });
  return bytes;
}
template <class Residual>
void set_metric(Laps<Residual>& laps) {
  if (Residual::dim == 4) laps.map->change_world({WorldChange<typename Residual::Scalar>::Kind::transformed, {}, {}});
}

}  // namespace

TEST_CASE("map_archive: checksum") {
  const std::string_view text = "123456789";
  CHECK(crc32(std::as_bytes(std::span<const char>(text))) == 0xCBF43926u);
}

TEMPLATE_TEST_CASE("map_archive: a restored map is the one that was saved", "", RelativePoseResidual<double>,
                   RelativePoseYawResidual<float>, RelativeSim3Residual<double>) {
  Laps<TestType> laps(2);
  set_metric(laps);
  for (int k = 0; k < 2 * per_lap; ++k) laps.step();
  REQUIRE(laps.map->counts().loops > 0);
  const auto bytes = saved(*laps.map);
  Laps<TestType> other(2);
  REQUIRE(other.map->load(bytes) == MapArchiveError::none);
  const auto &a = laps.map->places(), &b = other.map->places();
  using S = typename TestType::Scalar;
  const S tolerance = 100 * std::numeric_limits<S>::epsilon();
  REQUIRE(b.size() == a.size() - int(test::window));  // without those in the window
  int loops = 0;
  for (int l = 0; l < a.graph().loops(); ++l)
    loops += a.keyframe(a.graph().loop(l).i).is_retired && a.keyframe(a.graph().loop(l).j).is_retired;
  REQUIRE((loops > 0 && b.graph().loops() == loops));
  for (int k = 0; k < b.size(); ++k) {
    const auto &x = a.keyframe(k), &y = b.keyframe(k);
    CHECK((x.id == y.id && x.t_ns == y.t_ns && y.is_retired && x.features.size() == y.features.size()));
    const Sim3<S> apart = Sim3<S>(a.graph().pose(k)).inverse() * Sim3<S>(b.graph().pose(k));
    CHECK(norm(apart.t()) + norm(apart.rotation().log()) + std::abs(apart.scale() - 1) < 20 * tolerance);
    bool same = true;
    for (std::size_t n = 0; n < x.features.size(); ++n) {
      same = same && x.features[n].descriptor == y.features[n].descriptor &&
             x.features[n].range == y.features[n].range && x.features[n].bearing == y.features[n].bearing;
    }
    CHECK(same);
    if (k == 0) continue;
    const auto P = a.graph().odometry(k).covariance(), Q = b.graph().odometry(k).covariance();
    CHECK(norm(Vec<S, TestType::dim>((P - Q).diagonal())) <= S(1e-3) * norm(Vec<S, TestType::dim>(P.diagonal())));
  }
  CHECK(saved(*other.map).size() == bytes.size());
  CHECK(other.map->load(bytes) == MapArchiveError::not_empty);
}

TEMPLATE_TEST_CASE("map_archive: a run finds itself in the map of another one, and extends it or not", "",
                   RelativePoseResidual<double>, RelativePoseYawResidual<float>, RelativeSim3Residual<double>) {
  Laps<TestType> first(2);
  set_metric(first);
  first.drift_rad = 0;
  for (int k = 0; k < per_lap + 20; ++k) first.step();
  const auto bytes = saved(*first.map);
  for (const bool localize_only : {false, true}) {
    KeyframeMapOptions options;
    options.localize_only = localize_only;
    Laps<TestType> second(2, options);
    REQUIRE(second.map->load(bytes) == MapArchiveError::none);
    set_metric(second);
    CHECK(!second.map->is_in_map());
    second.drift_rad = 0.001;
    second.T_begin = SE3<double>(SO3<double>::exp({0, 0, 1.0}), {5, -3, 2});
    second.first = 17;  // begins elsewhere on the lap
    if (TestType::dim == 7) second.scale = 0.5;
    for (int k = 0; k < per_lap; ++k) second.step();
    CHECK(second.map->is_in_map());
    CHECK(second.map->counts().relocalizations == 1);
    CHECK(second.map_error() < 0.1);
    const auto again = saved(*second.map);
    if (localize_only) {
      Laps<TestType> reader(2);
      REQUIRE(reader.map->load(bytes) == MapArchiveError::none);
      for (int k = 0; k < reader.map->places().size(); ++k)
        CHECK(reader.map->places().graph().pose(k).rotation().quaternion().coeffs() ==
              second.map->places().graph().pose(k).rotation().quaternion().coeffs());
      CHECK(second.map->places().size() <= reader.map->places().size() + 41);
    } else {
      CHECK(again.size() > bytes.size());
    }
  }
}

TEST_CASE("map_archive: a small map can be localized in, too") {
  Laps<RelativePoseResidual<double>> first(2);
  first.drift_rad = 0;
  for (int k = 0; k < 22; ++k) first.step();
  KeyframeMapOptions options;
  options.localize_only = true;
  Laps<RelativePoseResidual<double>, 32> second(2, options);
  REQUIRE(second.map->load(saved(*first.map)) == MapArchiveError::none);
  CHECK(second.map->loaded() == 14);
  for (int k = 0; k < 20; ++k) second.step();
  CHECK(second.map->is_in_map());
  CHECK(second.map_error() < 0.1);
}

TEST_CASE("map_archive: worlds that are not connected are not saved") {
  Laps<RelativePoseResidual<double>> laps(4);
  for (int k = 0; k < 15; ++k) laps.step();
  const auto before = saved(*laps.map);
  laps.map->change_world({WorldChange<double>::Kind::reset, {}, {}});
  laps.first = 15;
  for (int k = 0; k < 10; ++k) laps.step();
  MapArchiveHeader a, b;
  REQUIRE(map_archive::read_header(before, a) == MapArchiveError::none);
  REQUIRE(map_archive::read_header(saved(*laps.map), b) == MapArchiveError::none);
  CHECK(b.keyframes <= 15);
  CHECK(b.keyframes >= a.keyframes);
}

TEST_CASE("map_archive: a start that was given up does not take the place of the map") {
  Laps<RelativePoseResidual<double>> laps(4);
  for (int k = 0; k < 10; ++k) laps.step();  // two of them retire
  laps.map->change_world({WorldChange<double>::Kind::reset, {}, {}});
  CHECK(laps.map->is_in_map());
  laps.first = 25;
  for (int k = 0; k < 20; ++k) laps.step();
  MapArchiveHeader header;
  REQUIRE(map_archive::read_header(saved(*laps.map), header) == MapArchiveError::none);
  CHECK(header.keyframes >= 12);
}

TEST_CASE("map_archive: damaged, foreign and too large maps are named, and nothing is taken in") {
  Laps<RelativePoseResidual<float>> laps(2);
  for (int k = 0; k < per_lap + 20; ++k) laps.step();
  const auto bytes = saved(*laps.map);
  const auto error_of = [&](std::span<const std::byte> damaged) {
    Laps<RelativePoseResidual<float>> other(2);
    const MapArchiveError error = other.map->load(damaged);
    REQUIRE((error == MapArchiveError::none || other.map->places().size() == 0));
    return error;
  };
  CHECK(error_of({}) == MapArchiveError::not_a_map);
  CHECK(error_of(std::as_bytes(std::span<const char>("plumbmap"))) == MapArchiveError::other_version);
  CHECK(error_of(std::span(bytes).first(bytes.size() - 1)) == MapArchiveError::cut_off);
  Laps<RelativeSim3Residual<float>> mono(2);
  CHECK(mono.map->load(bytes) == MapArchiveError::other_sensors);
  Laps<RelativePoseResidual<float>, 20> small(2);
  CHECK(small.map->load(bytes) == MapArchiveError::no_room);
  Random random(3);
  auto damaged = bytes;
  for (int run = 0; run < 1000; ++run) {
    const std::size_t at = random.below(std::uint32_t(bytes.size()));
    damaged[at] ^= std::byte(1u << random.below(8));
    CHECK(error_of(damaged) != MapArchiveError::none);
    // The same with a checksum that is right: no crash, and poses that are finite.
    const std::uint32_t sum = crc32(std::span(damaged).first(damaged.size() - 4));
    for (std::size_t k = 0; k < 4; ++k) damaged[damaged.size() - 4 + k] = std::byte(sum >> (8 * k));
    error_of(damaged);
    damaged = bytes;
  }
}
