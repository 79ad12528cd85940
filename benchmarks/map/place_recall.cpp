// Recall at full precision of the place index, for recordings in the TUM or EuRoC layout:
//   bench_map_place_recall [--every N] FOLDER...
// Each recording is asked alone, and with the keyframes of all others in the index as a background.
#if __has_include(<opencv2/imgcodecs.hpp>)
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "../../tests/map/recorded_keyframes.hpp"
#include "plumbline/map/hamming_place_index.hpp"

int main(int argc, char** argv) {
  using namespace plumbline;
  std::size_t every = 5;
  std::vector<std::string> folders;
  for (int i = 1; i < argc; ++i) {
    if (std::string(argv[i]) == "--every" && i + 1 < argc) {
      every = std::stoul(argv[++i]);
    } else {
      folders.push_back(argv[i]);
    }
  }
  std::vector<std::vector<testing::RecordedKeyframe>> runs;
  for (const std::string& folder : folders) runs.push_back(testing::recorded_keyframes(folder, every));
  const auto index = std::make_unique<HammingPlaceIndex<1500, 300>>();
  std::printf(
      "recall at full precision: wrong is further than 2 m or 60 deg (strict: 1 m or 30 deg); best: the best "
      "candidate is right\n");
  for (std::size_t i = 0; i < runs.size(); ++i) {
    std::vector<testing::RecordedKeyframe> others;
    for (std::size_t j = 0; j < runs.size(); ++j) {
      if (j != i) others.insert(others.end(), runs[j].begin(), runs[j].end());
    }
    std::printf("%s: %zu keyframes", folders[i].c_str(), runs[i].size());
    for (const bool with_background : {false, true}) {
      const testing::PlaceRecall r =
          testing::place_recall(*index, runs[i],
                                with_background ? std::span<const testing::RecordedKeyframe>(others)
                                                : std::span<const testing::RecordedKeyframe>());
      if (!with_background) std::printf(", %d revisits\n", r.revisits);
      std::printf("  %s: recall %.2f above score %.4f, strict %.2f, best %.2f\n",
                  with_background ? "with the others" : "alone          ", r.recall, double(r.threshold), r.strict,
                  r.first);
    }
  }
}
#else
int main() {}
#endif
