#pragma once
/// A page on 127.0.0.1 that shows the trajectory of `plumbline live` as it grows: the page `live` of benchmarks/report,
/// which asks for the poses that are new.
///
///   GET /                      the page
///   GET /poses?from=N&part=P   JSON: the poses from the N-th one on, or all where `part` is not the present one

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>

#include "runner.hpp"

class LivePage {
 public:
  static constexpr std::size_t most_poses = 100'000;  ///< of more every second one is left out

  /// Port 0 is a free one; the address is printed. Throws Misuse where the program is built without pages, and
  /// std::runtime_error where the port is taken.
  LivePage(int port, std::string title, bool has_imu);
  LivePage(const LivePage&) = delete;
  LivePage& operator=(const LivePage&) = delete;
  ~LivePage();

  void add(const FrameOutput& output, bool is_sound, std::size_t dropped);
  void set_over();

 private:
  struct Server;
  struct Pose {
    double t_s;
    float x, y, z;
  };

  nlohmann::json poses(std::size_t from, std::uint32_t part) const;

  std::string title_;
  bool has_imu_;
  mutable std::mutex mutex_;
  std::vector<Pose> poses_;
  std::size_t every_ = 1, sound_ = 0, frames_ = 0, dropped_ = 0;
  std::uint32_t part_ = 0;  ///< counts how often poses were left out
  std::string health_ = "initializing", reason_ = "none";
  double total_ms_ = 0;
  bool is_over_ = false;
  std::unique_ptr<Server> server_;
};
