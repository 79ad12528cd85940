// Any bytes as a saved map: a map takes all of it in or stays as it was. What was taken in is finite, is saved as it
// was read, and a run that sees its places again can be saved and loaded.
#include <cmath>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "checksums.hpp"
#include "fuzz_folder.hpp"
#include "plumbline/io/map_file.hpp"
#include "plumbline/map/keyframe_map.hpp"

namespace pl = plumbline;

namespace {

template <class Residual>
using Map = pl::KeyframeMapCore<Residual, 24, 48, 8>;

template <class Core>
std::vector<std::byte> saved(const Core& map) {
  std::vector<std::byte> bytes;
  map.save([&](std::span<const std::byte> part) { bytes.insert(bytes.end(), part.begin(), part.end()); });
  return bytes;
}

template <class Core>
void require_finite(const Core& map) {
  for (int k = 0; k < map.places().size(); ++k)
    require(map.places().graph().pose(k).is_finite(), "a pose of the map is finite");
  require(map.S_map_world().is_finite(), "a correction is finite");
}

/// Keyframes that see what those of the map saw.
template <class Core>
void walk(Core& map) {
  using S = typename Core::S;
  if (Core::Places::has_gravity) map.change_world({pl::WorldChange<S>::Kind::transformed, {}, {}});
  const int loaded = map.loaded();
  pl::Mat<S, 6, 6> covariance = pl::zeros<S, 6, 6>();
  for (int k = 0; k < 6; ++k) covariance(k, k) = S(1e-4);
  for (int step = 0; step < 4 && step < loaded; ++step) {
    const auto features = map.places().keyframe(step).features;
    const pl::SE3<S> T_world_body = map.places().keyframe(step).T_world_body;
    const std::uint32_t id = std::uint32_t(step) + 1;
    if (auto* keyframe = map.begin_keyframe(id, pl::TimeNs(id) * 100'000'000, T_world_body, {}, covariance)) {
      keyframe->features = features;
      map.finish_keyframe();
    }
    if (step > 0) map.retire(id - 1, map.places().keyframe(step - 1).T_world_body);
    for (int frame = 0; frame < 8; ++frame) map.work();
  }
}

template <class Residual>
void run(std::span<const std::byte> bytes, bool localize_only) {
  using Core = Map<Residual>;
  pl::KeyframeMapOptions options;
  options.localize_only = localize_only;
  static const std::vector<std::byte> empty = saved(*std::make_unique<Core>(pl::KeyframeMapOptions{}));
  const auto map = std::make_unique<Core>(options);
  if (map->load(bytes) != pl::MapArchiveError::none) {
    require(map->places().size() == 0 && map->loaded() == 0 && saved(*map) == empty, "a refused map changes nothing");
    return;
  }
  require_finite(*map);
  const std::vector<std::byte> again = saved(*map);
  require(again.size() <= bytes.size(), "nothing is added by saving");  // less: worlds without a loop between them
  const auto other = std::make_unique<Core>(options);
  require(other->load(again) == pl::MapArchiveError::none, "a map can be loaded that was saved");
  walk(*map);
  require_finite(*map);
  const auto reader = std::make_unique<Core>(pl::KeyframeMapOptions{});
  require(reader->load(saved(*map)) == pl::MapArchiveError::none, "a map can be loaded that was extended");
}

}  // namespace

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  size = LLVMFuzzerMutate(data, size, max_size);
  if (seed % 8 != 0) repair_map({data, size});
  return size;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  expect_read_error_at_most([&] {
    const pl::io::MapContents contents = pl::io::map_of_bytes(bytes, "a.map");
    std::size_t located = 0;
    for (const auto& keyframe : contents.keyframes)
      keyframe.for_each_point([&](const auto&, const pl::Vec<double, 3>&, double) { ++located; });
    require(located <= contents.header.features, "points are features");
  });
  const bool localize_only = size > 0 && data[size - 1] % 2 != 0;
  run<pl::RelativePoseResidual<double>>(bytes, localize_only);
  run<pl::RelativePoseYawResidual<float>>(bytes, localize_only);
  run<pl::RelativeSim3Residual<float>>(bytes, localize_only);
  return 0;
}
