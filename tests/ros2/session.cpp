#include "plumbline_ros2/session.hpp"

#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "message_like.hpp"
#include "plumbline/lie/plus.hpp"

using namespace plumbline;
using namespace plumbline::ros2;

namespace {

constexpr TimeNs ms = 1'000'000;

/// What an estimator was given, and an answer of the test's choice.
struct Record {
  std::vector<TimeNs> imu_ns, frames_ns;
  std::vector<int> gray, depth;  // of the first pixel; -1 without depth
  std::function<FrameOutput(TimeNs)> answer;
};

class RecordingRunner final : public Runner {
 public:
  explicit RecordingRunner(Record& record) : record_(record) {}
  std::optional<Error> add_imu(const ImuSample& sample) override {
    record_.imu_ns.push_back(sample.t_ns);
    return sample.t_ns < 0 ? std::optional(Error::late_sample) : std::nullopt;
  }
  FrameOutput add_frame(TimeNs t_ns, const cv::Mat& gray, const cv::Mat& depth) override {
    record_.frames_ns.push_back(t_ns);
    record_.gray.push_back(gray.at<std::uint8_t>(0, 0));
    record_.depth.push_back(depth.empty() ? -1 : depth.at<std::uint16_t>(0, 0));
    return record_.answer(t_ns);
  }
  double time_offset_s() const override { return 0; }
  std::vector<Vec<double, 3>> landmarks() const override { return {}; }
  std::vector<MapFeature> map() const override { return {}; }
  MapArchiveError load_map(std::span<const std::byte>) override { return {}; }
  std::vector<std::byte> saved_map() override { return {}; }
  std::optional<MapSummary> map_summary() const override { return {}; }
  std::optional<MapSnapshot> map_snapshot(std::size_t) const override { return {}; }
  FeatureCounts seen() const override { return {}; }
  std::size_t bytes() const override { return 0; }
  Inspection inspect() const override { return {}; }

 private:
  Record& record_;
};

FrameOutput tracked(TimeNs t_ns, double x) {
  FrameOutput out;
  out.estimate.t_ns = t_ns;
  out.estimate.T_world_body = SE3<double>(SO3<double>(), Vec<double, 3>(x, 0, 0));
  out.estimate.health = {HealthState::tracking, HealthReason::none};
  return out;
}

io::Calibration calibration() {
  io::Calibration out;
  out.camera.width = 4;
  out.camera.height = 3;
  out.depth_scale = 1000;
  return out;
}

HeldImage gray_at(TimeNs t_ns, std::uint8_t value, std::uint32_t width = 4) {
  auto image = message_like::gray_image(0, static_cast<std::uint32_t>(t_ns), width, 3, value);
  return held_image_of<message_like::Image>(std::make_shared<message_like::Image>(std::move(image)));
}
HeldImage depth_at(TimeNs t_ns, float meters) {
  auto image = message_like::gray_image(0, static_cast<std::uint32_t>(t_ns), 4, 3, 0);
  const std::vector<float> pixels(12, meters);
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(pixels.data());
  image.encoding = "32FC1";
  image.step = 16;
  image.data.assign(bytes, bytes + 48);
  return held_image_of<message_like::Image>(std::make_shared<message_like::Image>(std::move(image)));
}

/// A session with what came out of it.
struct Run {
  explicit Run(const Needs& needs, const Parameters& parameters = {})
      : session(needs, calibration(), std::make_unique<RecordingRunner>(record), parameters,
                {[this](const Odometry& odometry) { odometries.push_back(odometry); },
                 [this](const std::string& note) {
                   const std::lock_guard lock(mutex);
                   notes.push_back(note);
                 }}) {}
  Record record{{}, {}, {}, {}, [](TimeNs t_ns) { return tracked(t_ns, 0); }};
  std::vector<Odometry> odometries;
  std::vector<std::string> notes;
  std::mutex mutex;
  Session session;
};

}  // namespace

TEST_CASE("a frame comes after the IMU samples up to its time and the first one at or after it") {
  Run run({.depth = false, .imu = true});
  run.record.answer = [](TimeNs t_ns) {
    FrameOutput out = tracked(t_ns, 1);
    out.estimate.v_world_body = Vec<double, 3>(2, 0, 0);
    out.estimate.bias_gyro = Vec<double, 3>(0, 0, 0.5);
    return out;
  };
  for (const TimeNs t : {0, 10, 20}) run.session.add(ImuSample{t * ms, {0, 0, 0}, {0, 0, 9.81}});
  run.session.add_gray(gray_at(25 * ms, 70));
  for (const TimeNs t : {30, 40}) run.session.add(ImuSample{t * ms, {0, 0, 1.5}, {0, 0, 9.81}});
  run.session.add_gray(gray_at(35 * ms, 71));
  run.session.finish();
  REQUIRE(run.record.frames_ns == std::vector<TimeNs>{25 * ms, 35 * ms});
  REQUIRE(run.record.gray == std::vector<int>{70, 71});
  REQUIRE(run.record.imu_ns == std::vector<TimeNs>{20 * ms, 30 * ms, 40 * ms});
  REQUIRE(run.odometries.size() == 2);
  REQUIRE(run.odometries[1].t_ns == 35 * ms);
  REQUIRE(run.odometries[1].twist.linear.x() == Approx(2));
  REQUIRE(run.odometries[1].twist.angular.z() == Approx(1.5 - 0.5));
  REQUIRE(!run.odometries[1].T_map_odom);
  REQUIRE(run.session.status().counts.poses == 2);
  REQUIRE(run.session.status().health.state == HealthState::tracking);
}

TEST_CASE("a frame with depth has both images; without an IMU the twist is the mean between poses") {
  Run run({.depth = true, .imu = false});
  run.record.answer = [](TimeNs t_ns) {
    return tracked(t_ns, 1e-9 * static_cast<double>(t_ns));
  };  // to the right, 1 m/s
  run.session.add_depth(depth_at(100 * ms, 2));
  run.session.add_gray(gray_at(101 * ms, 9));
  run.session.add_gray(gray_at(200 * ms, 10));  // without depth
  run.session.add_gray(gray_at(300 * ms, 11));
  run.session.add_depth(depth_at(300 * ms, 3));
  run.session.add(ImuSample{});  // not used
  run.session.finish();
  REQUIRE(run.record.gray == std::vector<int>{9, 11});
  REQUIRE(run.record.depth == std::vector<int>{2000, 3000});
  REQUIRE(run.record.imu_ns.empty());
  REQUIRE(run.odometries.size() == 2);
  REQUIRE(run.odometries[0].twist.linear.norm() == 0);
  REQUIRE((run.odometries[1].twist.linear - Vec<double, 3>(0, -1, 0)).norm() < 1e-9);  // REP 103: y to the left
  REQUIRE(run.session.status().counts.without_depth == 1);
  REQUIRE(run.notes.size() == 1);
  REQUIRE(run.notes[0].find("no depth image") != std::string::npos);
}

TEST_CASE("the oldest frame is dropped, and said so, where more wait than the queue has room for") {
  Parameters p;
  p.queue = 2;
  Run run({.depth = false, .imu = false}, p);
  std::promise<void> begun, may_go_on;
  bool is_first = true;
  run.record.answer = [&](TimeNs t_ns) {
    if (std::exchange(is_first, false)) {
      begun.set_value();
      may_go_on.get_future().wait();
    }
    return tracked(t_ns, 0);
  };
  run.session.add_gray(gray_at(1 * ms, 1));
  begun.get_future().wait();
  for (std::uint8_t i = 2; i <= 6; ++i) run.session.add_gray(gray_at(i * ms, i));
  REQUIRE(run.session.status().counts.dropped == 3);
  REQUIRE(run.session.status().waiting == 2);
  may_go_on.set_value();
  run.session.finish();
  REQUIRE(run.record.gray == std::vector<int>{1, 5, 6});
  REQUIRE(run.notes == std::vector<std::string>{"falls behind: 1 frames are dropped so far",
                                                "falls behind: 2 frames are dropped so far"});
}

TEST_CASE(
    "images of another size, refused frames and samples are counted and noted; poses that are not sound are not "
    "published") {
  Run run({.depth = false, .imu = true});
  run.record.answer = [](TimeNs t_ns) {
    FrameOutput out = tracked(t_ns, 0);
    if (t_ns == 20 * ms) out.refused = Error::late_sample;
    if (t_ns == 30 * ms) out.estimate.health = {HealthState::lost, HealthReason::few_features};
    return out;
  };
  run.session.add(ImuSample{-5, {0, 0, 0}, {0, 0, 0}});
  run.session.add_gray(gray_at(10 * ms, 1, 5));
  run.session.add_gray(gray_at(20 * ms, 2));
  run.session.add_gray(gray_at(30 * ms, 3));
  run.session.finish();
  const Status status = run.session.status();
  REQUIRE(run.odometries.empty());
  REQUIRE(status.counts.skipped == 1);
  REQUIRE(status.counts.refused == 1);
  REQUIRE(status.counts.refused_imu == 1);
  REQUIRE(status.counts.frames == 2);
  REQUIRE(level_of(status) == Level::error);
  REQUIRE(run.notes.size() == 3);
  REQUIRE(run.notes[1].find("the image is 5 x 3, the calibration has 4 x 3") != std::string::npos);
}

TEST_CASE("map -> odom takes the base of odom to that of the map, whatever the scale of the correction") {
  Parameters p;
  p.map = true;
  p.T_base_body = {0.1, 0.2, 0.3, 0, 0, 0, 1};
  Run run({.depth = false, .imu = false}, p);
  const Sim3<double> S(2, SO3<double>::exp(Vec<double, 3>(0.1, 0.2, 0.3)), Vec<double, 3>(4, 5, 6));
  run.record.answer = [&](TimeNs t_ns) {
    FrameOutput out = tracked(t_ns, 3);
    out.S_map_world = S;
    return out;
  };
  run.session.add_gray(gray_at(10 * ms, 1));
  run.session.finish();
  REQUIRE(run.odometries.size() == 1);
  const FrameOutput output = run.record.answer(0);
  const SE3<double> T_base_body = T_base_body_of(p, false);
  const SE3<double> T_map_base = *run.odometries[0].T_map_odom * run.odometries[0].T_odom_base;
  REQUIRE(minus(T_map_base, T_base_body * output.T_map_body() * T_base_body.inverse()).norm() < 1e-12);
}
