#pragma once
/// A page on 127.0.0.1 that shows the trajectory of `plumbline live` as it grows, and its map: the page `live` of
/// benchmarks/report, which asks for what is new. The estimator never waits for it: answers are made of copies.
///
///   GET /                      the page
///   GET /poses?from=N&part=P   JSON: poses from the N-th one on, at most 10000; from the first one where `part` is not
///                              the present one
///   GET /map?version=V         JSON: the map as it was at most about a second ago; where that is version V, no more
///                              than its number. At most 6000 points.

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>

#include "map_snapshot.hpp"
#include "runner.hpp"

class LivePage {
 public:
  static constexpr std::size_t most_poses = 100'000;  ///< of more every second one is left out
  static constexpr std::size_t most_points = 6000;    ///< of a map

  /// Port 0 is a free one; the address is printed. Throws Misuse where the program is built without pages, and
  /// std::runtime_error where the port is taken.
  LivePage(int port, std::string title, bool has_imu);
  LivePage(const LivePage&) = delete;
  LivePage& operator=(const LivePage&) = delete;
  ~LivePage();

  void add(const FrameOutput& output, bool is_sound, std::size_t dropped);
  /// A reader has asked for the map since the last one, which is a second old.
  bool wants_map() const;
  /// For the first time before the first frame is added.
  void set_map(MapSnapshot map);
  void set_over();

 private:
  struct Server;
  struct Pose {
    double t_s;
    plumbline::Vec<float, 3> p_map, p_world;  ///< in the map as it was then
  };
  using Clock = std::chrono::steady_clock;

  nlohmann::json poses(std::size_t from, std::uint32_t part) const;
  nlohmann::json map(std::uint64_t version) const;

  std::string title_;
  bool has_imu_;
  mutable std::mutex mutex_;
  std::vector<Pose> poses_;
  std::size_t every_ = 1, sound_ = 0, frames_ = 0, dropped_ = 0;
  std::uint32_t part_ = 0;  ///< counts how often poses were left out
  std::string health_ = "initializing", reason_ = "none";
  double total_ms_ = 0;
  bool is_over_ = false;
  std::vector<Pose> relocalizations_;
  int relocalized_ = 0;
  std::shared_ptr<const MapSnapshot> map_;  ///< none of an estimator without a map
  std::uint64_t version_ = 0;               ///< of the map
  Clock::time_point mapped_{};
  mutable std::atomic<bool> is_map_asked_ = true;
  std::unique_ptr<Server> server_;
};
