// Places are found again on recordings. The bounds are below what docs/decisions/120-place-recognition.md measures.
#include "map/recorded_keyframes.hpp"

#include <iostream>
#include <memory>

#include "catch.hpp"
#include "plumbline/map/hamming_place_index.hpp"

using namespace plumbline;

TEST_CASE("place recall: places of the recordings are recognized", "[data]") {
  struct Bound {
    const char* folder;
    double recall, first;
  };
  const auto index = std::make_unique<HammingPlaceIndex<100, 300>>();
  for (const Bound& bound : {Bound{"tum_fr1_rpy_first12s", 0.75, 0.85}, Bound{"rendered_office_mono", 0.2, 0.6},
                             Bound{"rendered_lowtex_rgbd", 0.3, 0.5}}) {
    const std::string path = std::string(PLUMBLINE_TEST_DATA) + "/" + bound.folder;
    if (skip_without(path)) return;
    const std::vector<testing::RecordedKeyframe> run = testing::recorded_keyframes(path, 5);
    const testing::PlaceRecall r = testing::place_recall(*index, run, {});
    std::cout << bound.folder << ": " << run.size() << " keyframes, " << r.revisits << " revisits, recall " << r.recall
              << " above " << r.threshold << ", best candidate right " << r.first << '\n';
    CAPTURE(bound.folder, r.recall, r.first);
    REQUIRE(r.revisits >= 10);
    REQUIRE(r.recall > bound.recall);
    REQUIRE(r.first > bound.first);
  }
}
