#include "plumbline_ros2/session.hpp"

#include <cmath>
#include <exception>
#include <utility>
#include <variant>

#include "calibrated_sensors.hpp"

namespace plumbline::ros2 {

Session::Session(const Needs& needs, const io::Calibration& calibration, std::unique_ptr<Runner> runner,
                 const Parameters& parameters, Callbacks callbacks)
    : needs_(needs),
      calibration_(calibration),
      runner_(std::move(runner)),
      with_map_(parameters.map),
      all_poses_(parameters.all_poses),
      base_(T_base_body_of(parameters, needs.imu), needs.imu),
      callbacks_(std::move(callbacks)),
      pairing_(std::llround(parameters.depth_tolerance_s * 1e9)),
      queue_({static_cast<std::size_t>(parameters.queue), false, needs.imu}, stop_) {
  thread_ = std::thread([this] { work(); });
}

Session::~Session() {
  stop_ = true;
  finish();
}

void Session::finish() {
  queue_.end(nullptr);
  if (thread_.joinable()) thread_.join();
}

void Session::add(const ImuSample& sample) {
  if (!needs_.imu || queue_.add(sample)) return;
  const std::lock_guard lock(status_mutex_);
  ++status_.counts.refused_imu;
}

void Session::add_gray(HeldImage gray) {
  if (!needs_.depth) {
    const TimeNs t_ns = gray.image.t_ns;
    return add_frame({frame_time(needs_, calibration_, t_ns), std::move(gray), {}});
  }
  std::unique_lock lock(input_);
  auto pair = pairing_.add_gray(std::move(gray));
  lock.unlock();
  add_pair(std::move(pair));
}

void Session::add_depth(HeldImage depth) {
  if (!needs_.depth) return;
  std::unique_lock lock(input_);
  auto pair = pairing_.add_depth(std::move(depth));
  lock.unlock();
  add_pair(std::move(pair));
}

void Session::add_pair(std::optional<DepthPairing::Pair> pair) {
  std::unique_lock lock(input_);
  const std::size_t without = pairing_.dropped();
  const bool is_due = without_depth_.is_due(without);
  lock.unlock();
  {
    const std::lock_guard status_lock(status_mutex_);
    status_.counts.without_depth = without;
  }
  if (is_due)
    callbacks_.on_note(std::to_string(without) +
                       " images are dropped so far: no depth image has their time stamp (depth_tolerance_s)");
  if (!pair) return;
  const TimeNs t_ns = pair->first.image.t_ns;
  add_frame({frame_time(needs_, calibration_, t_ns), std::move(pair->first), std::move(pair->second)});
}

void Session::add_frame(Frame frame) {
  queue_.add(std::move(frame));
  const std::size_t dropped = queue_.dropped();
  std::unique_lock lock(input_);
  const bool is_due = dropped_.is_due(dropped);
  lock.unlock();
  {
    const std::lock_guard status_lock(status_mutex_);
    status_.counts.dropped = dropped;
    latest_frame_ = std::chrono::steady_clock::now();
  }
  if (is_due) callbacks_.on_note("falls behind: " + std::to_string(dropped) + " frames are dropped so far");
}

void Session::work() {
  while (const auto sample = queue_.next(runner_->time_offset_s())) {
    if (const ImuSample* imu = std::get_if<ImuSample>(&*sample)) {
      gyro_ = imu->gyro;
      const std::optional<Error> error = runner_->add_imu(*imu);
      if (!error) continue;
      std::unique_lock lock(status_mutex_);
      const std::size_t count = ++status_.counts.refused_imu;
      lock.unlock();
      if (refused_imu_.is_due(count))
        callbacks_.on_note(std::to_string(count) + " IMU samples are refused so far (latest: " + name_of(*error) + ")");
    } else {
      estimate(std::get<Frame>(*sample));
    }
  }
}

void Session::estimate(const Frame& frame) {
  const int width = calibration_.camera.width, height = calibration_.camera.height;
  cv::Mat gray, depth;
  try {
    gray = gray_of(frame.gray, width, height);
    if (frame.depth) depth = depth_of(*frame.depth, width, height, calibration_.depth_scale);
  } catch (const std::exception& damage) {
    std::unique_lock lock(status_mutex_);
    const std::size_t count = ++status_.counts.skipped;
    lock.unlock();
    if (skipped_.is_due(count))
      callbacks_.on_note(std::to_string(count) + " images are skipped so far (latest: " + damage.what() + ")");
    return;
  }
  const FrameOutput output = runner_->add_frame(frame.t_ns, gray, depth);
  const bool is_published =
      !output.refused && output.is_in_map && (all_poses_ ? output.has_pose() : output.has_sound_pose());
  std::size_t refused = 0;
  {
    const std::lock_guard lock(status_mutex_);
    Counts& counts = status_.counts;
    ++counts.frames;
    counts.poses += is_published;
    refused = counts.refused += output.refused.has_value();
    status_.health = output.estimate.health;
    status_.stage = output.start.stage;
    status_.tracked = output.estimate.tracked;
    status_.resets = output.estimate.resets;
    status_.loops = output.map_counts.loops;
    status_.total_ms = 1e3 * output.timing.total;
    status_.time_offset_s = output.estimate.time_offset_s;
  }
  if (output.refused && refused_.is_due(refused))
    callbacks_.on_note(std::to_string(refused) + " frames are refused so far (latest: " + name_of(*output.refused) +
                       ")");
  if (is_published)
    publish(output);
  else if (!output.refused)
    before_.reset();
}

void Session::publish(const FrameOutput& output) {
  const SE3<double>& T_world_body = output.estimate.T_world_body;
  Odometry out;
  out.t_ns = output.pose_ns();
  out.T_odom_base = base_.T_odom_base(T_world_body);
  out.covariance = covariance_in_odom(base_, T_world_body, output.estimate.covariance);
  if (needs_.imu) {
    const Vec<double, 3> w_body = gyro_ - output.estimate.bias_gyro;
    out.twist = twist_of(base_, T_world_body, output.estimate.v_world_body, w_body);
  } else if (before_ && resets_before_ == output.estimate.resets) {
    out.twist = mean_twist(before_->T_odom_base, out.T_odom_base, 1e-9 * static_cast<double>(out.t_ns - before_->t_ns));
  }
  if (with_map_) out.T_map_odom = base_.T_odom_base(output.T_map_body()) * out.T_odom_base.inverse();
  callbacks_.on_odometry(out);
  before_ = out;
  resets_before_ = output.estimate.resets;
}

Status Session::status() const {
  const std::lock_guard lock(status_mutex_);
  Status out = status_;
  out.waiting = queue_.waiting();
  out.silent_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - latest_frame_).count();
  return out;
}

}  // namespace plumbline::ros2
