#pragma once
/// The estimator in a thread of its own, behind a queue of bounded length: messages in, odometry out. What is not used
/// is counted, and noted when the number has doubled. No header of ROS is needed.

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "plumbline/imu/sample.hpp"
#include "plumbline/io/calibration_data.hpp"
#include "plumbline_ros2/conversions.hpp"
#include "plumbline_ros2/depth_pairing.hpp"
#include "plumbline_ros2/diagnostics.hpp"
#include "plumbline_ros2/odometry.hpp"
#include "plumbline_ros2/parameters.hpp"
#include "runner.hpp"
#include "sample_queue.hpp"

namespace plumbline::ros2 {

class Session {
 public:
  struct Callbacks {
    std::function<void(const Odometry&)> on_odometry;  ///< in the thread of the estimator
    std::function<void(const std::string&)> on_note;   ///< in any thread
  };

  Session(const Needs& needs, const io::Calibration& calibration, std::unique_ptr<Runner> runner,
          const Parameters& parameters, Callbacks callbacks);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  /// What waits is dropped.
  ~Session();

  void add(const ImuSample& sample);
  void add_gray(HeldImage gray);
  void add_depth(HeldImage depth);
  /// No more comes: returns once all that waits is done.
  void finish();

  Status status() const;

 private:
  struct Frame {
    TimeNs t_ns;  ///< for the estimator
    HeldImage gray;
    std::optional<HeldImage> depth;
  };
  /// Whether it is time for another note of a count: it has doubled.
  struct Doubling {
    std::size_t noted = 0;
    bool is_due(std::size_t count) {
      if (count == 0 || count < 2 * noted) return false;
      noted = count;
      return true;
    }
  };

  void add_pair(std::optional<DepthPairing::Pair> pair);
  void add_frame(Frame frame);
  void work();
  void estimate(const Frame& frame);
  void publish(const FrameOutput& output);

  Needs needs_;
  io::Calibration calibration_;
  std::unique_ptr<Runner> runner_;
  bool with_map_, all_poses_;
  BaseFrame base_;
  Callbacks callbacks_;

  std::mutex input_;  // of the members up to the queue
  DepthPairing pairing_;
  Doubling dropped_, without_depth_;
  std::atomic<bool> stop_ = false;
  SampleQueue<Frame> queue_;

  mutable std::mutex status_mutex_;
  Status status_;
  std::chrono::steady_clock::time_point latest_frame_ = std::chrono::steady_clock::now();

  // Of the thread.
  Doubling skipped_, refused_, refused_imu_;
  Vec<double, 3> gyro_ = zeros<double, 3>();  // of the latest IMU sample
  std::optional<Odometry> before_;
  std::uint32_t resets_before_ = 0;
  std::thread thread_;
};

}  // namespace plumbline::ros2
