// Which keyframes of a map are saved, and what is taken in, of a place graph alone.
#include "plumbline/map/place_archive.hpp"

#include <cstdint>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/map/place_graph.hpp"
#include "plumbline/residual/relative_pose.hpp"
#include "plumbline/residual/relative_sim3.hpp"

using namespace plumbline;

namespace {

template <class Residual, int MaxKeyframes = 20, std::size_t MaxFeatures = 4>
using Places = PlaceGraph<Residual, MaxKeyframes, MaxFeatures, 4>;
using Rigid = Places<RelativePoseResidual<double>>;

template <class P>
std::unique_ptr<P> make_places() {
  return std::make_unique<P>(PlaceGraphOptions{});
}
template <class P>
void add(P& places, std::uint32_t id, bool retires = true, std::size_t features = 1) {
  using S = typename P::S;
  Mat<S, 6, 6> covariance = zeros<S, 6, 6>();
  for (int k = 0; k < 6; ++k) covariance(k, k) = S(1e-6 * (1 + id));
  const SE3<S> T(SO3<S>::exp({S(0), S(0), S(0.1) * S(id)}), {S(id), S(0.5), S(0)});
  REQUIRE(places.add(id, TimeNs(1000 * id), T, SE3<S>(), covariance));
  for (std::size_t k = 0; k < features; ++k) {
    PlaceFeature feature{};
    feature.descriptor.words[0] = 100 * id + k;
    feature.bearing = {0, 0, 1};
    feature.sigma_rad = 1e-3f;
    feature.range = float(id);
    feature.sigma_range = 0.1f;
    places.keyframe(places.size() - 1).features.push_back(feature);
  }
  if (retires) places.retire(id, T);
}
template <class P>
void add_loop(P& places, std::uint32_t i, std::uint32_t j) {
  using Covariance = typename P::Covariance;
  Covariance covariance = zeros<Covariance>();
  for (int k = 0; k < P::Residual::dim; ++k) covariance(k, k) = typename P::S(1e-4 * (1 + k));
  const int a = places.find(i), b = places.find(j);
  REQUIRE(places.graph().add_loop(a, b, places.graph().pose(a).inverse() * places.graph().pose(b), covariance) ==
          PoseGraphInsertion::inserted);
}
/// Worlds 0 (keyframes 1 to 3), 1 (4 to 7), 2 (8, 9) and 3 (10 to 12, of which two are in the window).
template <class P>
std::unique_ptr<P> four_worlds() {
  auto places = make_places<P>();
  for (std::uint32_t id = 1; id <= 12; ++id) {
    if (id == 4 || id == 8 || id == 10) places->begin_world();
    add(*places, id, id < 11);
  }
  return places;
}
template <class P>
std::vector<std::byte> saved(const P& places, std::uint32_t world) {
  std::vector<std::byte> bytes;
  save_places(
      places, [&](std::span<const std::byte> part) { bytes.insert(bytes.end(), part.begin(), part.end()); }, world);
  return bytes;
}
template <class P>
std::vector<std::uint32_t> ids_of(const P& places) {
  std::vector<std::uint32_t> out;
  for (int k = 0; k < places.size(); ++k) out.push_back(places.keyframe(k).id);
  return out;
}
using Ids = std::vector<std::uint32_t>;

}  // namespace

TEST_CASE("place_archive: the largest world has the most retired keyframes") {
  CHECK(largest_world(*make_places<Rigid>()) == 0);
  CHECK(largest_world(*four_worlds<Rigid>()) == 1);
  auto places = make_places<Rigid>();
  for (std::uint32_t id = 1; id <= 5; ++id) add(*places, id, id < 3);  // two of them have retired
  places->begin_world();
  for (std::uint32_t id = 6; id <= 8; ++id) add(*places, id);
  CHECK(largest_world(*places) == 1);
}

TEST_CASE("place_archive: saved is a world with those that loops connect with it, without what is in the window") {
  auto places = four_worlds<Rigid>();
  const auto restored_ids = [&](std::uint32_t world) {
    const auto other = make_places<Rigid>();
    REQUIRE(load_places(saved(*places, world), *other) == MapArchiveError::none);
    return ids_of(*other);
  };
  CHECK(restored_ids(0) == Ids{1, 2, 3});
  CHECK(restored_ids(3) == Ids{10});
  CHECK(restored_ids(7).empty());
  add_loop(*places, 9, 10);
  add_loop(*places, 2, 8);  // 0 is connected with 3 through 2, by the later loop first
  CHECK(restored_ids(0) == Ids{1, 2, 3, 8, 9, 10});
  CHECK(restored_ids(3) == Ids{1, 2, 3, 8, 9, 10});
  CHECK(restored_ids(1) == Ids{4, 5, 6, 7});

  const SavedPlaces<Rigid> of_first(*places, 0);
  CHECK(of_first.count() == 6);
  for (int k = 0; k < places->size(); ++k) {
    const std::uint32_t id = places->keyframe(k).id;
    CHECK(of_first.is_saved(k) == (id <= 3 || (id >= 8 && id <= 10)));
  }
  CHECK(of_first.index(places->find(8)) == 3);
}

TEMPLATE_TEST_CASE("place_archive: poses, features, loops and odometry come back, also across a keyframe left out", "",
                   RelativePoseResidual<double>, RelativePoseResidual<float>, RelativeSim3Residual<double>) {
  using P = Places<TestType>;
  using S = typename P::S;
  auto places = make_places<P>();
  for (std::uint32_t id = 1; id <= 6; ++id) add(*places, id, id != 3, id % 3);
  places->update();
  add_loop(*places, 1, 6);
  add_loop(*places, 3, 5);  // one of its ends is not saved
  const auto other = make_places<P>();
  REQUIRE(load_places(saved(*places, 0), *other) == MapArchiveError::none);
  REQUIRE(ids_of(*other) == Ids{1, 2, 4, 5, 6});
  CHECK(other->world() == 1);  // the present world is another one
  REQUIRE(other->graph().loops() == 1);
  CHECK((other->graph().loop(0).i == 0 && other->graph().loop(0).j == 4));
  const S tolerance = 100 * std::numeric_limits<S>::epsilon();
  for (int k = 0; k < other->size(); ++k) {
    const auto &was = places->keyframe(places->find(other->keyframe(k).id)), &is = other->keyframe(k);
    CHECK((is.t_ns == was.t_ns && is.is_retired));
    REQUIRE(is.features.size() == was.features.size());
    for (std::size_t n = 0; n < is.features.size(); ++n) {
      CHECK(is.features[n].descriptor == was.features[n].descriptor);
      CHECK(is.features[n].range == was.features[n].range);
    }
    const SE3<S> apart = is.T_world_body.inverse() * was.T_world_body;
    CHECK(norm(apart.p()) + norm(apart.rotation().log()) < tolerance);
  }
  // From 2 to 4, of which the keyframe between them is not saved: the motion, and no less noise than that of 2 to 3.
  const SE3<S> T = places->keyframe(1).T_world_body.inverse() * places->keyframe(3).T_world_body;
  CHECK(norm(Vec<S, 3>(other->keyframe(2).T_before.p() - T.p())) < tolerance);
  CHECK(other->keyframe(2).Q(3, 3) > places->keyframe(2).Q(3, 3));
  CHECK(other->keyframe(2).Q(3, 3) > places->keyframe(3).Q(3, 3));
}

TEST_CASE("place_archive: what does not fit is named, and nothing is taken in") {
  const auto bytes = saved(*four_worlds<Rigid>(), 1);
  const auto exact = make_places<Rigid>();
  CHECK(load_places(bytes, *exact, 4) == MapArchiveError::none);
  CHECK(load_places(bytes, *exact) == MapArchiveError::not_empty);
  CHECK(exact->size() == 4);
  const auto error_of = [&](auto places, int room) {
    const MapArchiveError error = load_places(bytes, *places, room);
    CHECK(places->size() == 0);
    return error;
  };
  CHECK(error_of(make_places<Rigid>(), 3) == MapArchiveError::no_room);
  CHECK(error_of(make_places<Rigid>(), -1) == MapArchiveError::no_room);
  CHECK(error_of(make_places<Places<RelativeSim3Residual<double>>>(), 20) == MapArchiveError::other_sensors);

  auto places = make_places<Rigid>();
  for (std::uint32_t id = 1; id <= 2; ++id) add(*places, id, true, 3);
  const auto fewer_features = make_places<Places<RelativePoseResidual<double>, 20, 2>>();
  CHECK(load_places(saved(*places, 0), *fewer_features) == MapArchiveError::no_room);
  CHECK(fewer_features->size() == 0);
}
