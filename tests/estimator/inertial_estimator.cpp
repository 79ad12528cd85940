// The estimator with an IMU on a recorded flight, as it was and with everything that real sensors do to it.
#include "plumbline/estimator/estimator.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/any_camera.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/io/make_camera.hpp"
#include "plumbline/io/recording.hpp"
#include "plumbline/io/trajectory_alignment.hpp"
#include "plumbline/io/trajectory_error.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/opencv/image_file.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"

using namespace plumbline;

namespace {

using Sensors = Rig<Mono<AnyCamera<double>, 752 * 480>, Imu>;
using Vio = Estimator<Sensors, Features<Points<250>>, SlidingWindow<10>>;

const std::filesystem::path flight = std::filesystem::path(PLUMBLINE_TEST_DATA) / "euroc_mh01_flight";

struct Trouble {
  /// Changes a sample at `t` [s] of the recording; false removes it.
  std::function<bool(double t, ImuSample&)> imu = [](double, ImuSample&) { return true; };
  /// The same for an image.
  std::function<bool(double t, cv::Mat&)> image = [](double, cv::Mat&) { return true; };
  SE3<double> T_cam_wrong;     ///< turns the camera's extrinsics
  double camera_offset_s = 0;  ///< added to the time of every image
  double noise_scale = 1;      ///< of the stated sample noise
  std::size_t shuffled = 1;    ///< so many samples are added together, in any order
  double duration_s = 14;
};

struct Flight {
  std::vector<Estimate<double>> estimates;
  InitReport init;
  ImuCounts counts;
  double begin_s = 0;
  io::Recording recording = io::Recording::open(flight);

  explicit Flight(const Trouble& trouble) {
    Sensors rig{};
    const io::Calibration& calibration = recording.calibration();
    rig.vision.camera = io::make_camera<double>(calibration.camera);
    rig.vision.width = calibration.camera.width;
    rig.vision.height = calibration.camera.height;
    rig.imu.T_body_cam = *calibration.T_body_camera * trouble.T_cam_wrong;
    rig.imu.noise = *calibration.imu;
    rig.imu.noise.accel_density *= trouble.noise_scale;
    rig.imu.noise.accel_walk *= trouble.noise_scale;
    const auto vio = std::make_unique<Vio>(rig);
    const TimeNs start = recording.frames().front().t_ns;
    const auto shown_at = [&](const io::FrameSample& frame) {
      return frame.t_ns + static_cast<TimeNs>(trouble.camera_offset_s * 1e9);
    };
    std::deque<io::FrameSample> waiting;  // for the IMU samples up to their time
    constexpr TimeNs patience_ns = 30'000'000;
    TimeNs read_until = 0;
    Random random(1);
    std::vector<ImuSample> together;
    io::Recording::Sample sample;
    while (recording.next(sample)) {
      if (const ImuSample* imu = std::get_if<ImuSample>(&sample)) {
        read_until = imu->t_ns;
        ImuSample changed = *imu;
        if (trouble.imu(seconds_between(start, imu->t_ns), changed)) together.push_back(changed);
        if (together.size() >= trouble.shuffled) {
          for (std::uint32_t i = std::uint32_t(together.size()); i > 1; --i)
            std::swap(together[i - 1], together[random.below(i)]);
          for (const ImuSample& each : together) (void)vio->add_imu(each);
          together.clear();
        }
      } else {
        waiting.push_back(std::get<io::FrameSample>(sample));
        if (seconds_between(start, waiting.back().t_ns) > trouble.duration_s) break;
      }
      for (; !waiting.empty() && shown_at(waiting.front()) + patience_ns <= read_until; waiting.pop_front()) {
        cv::Mat image = opencv::read_gray(waiting.front().image);
        if (!trouble.image(seconds_between(start, waiting.front().t_ns), image)) continue;
        const Result<Estimate<double>> estimate =
            vio->add_frame({shown_at(waiting.front()), opencv::view<std::uint8_t>(image)});
        REQUIRE(estimate);
        REQUIRE(estimate->T_world_body.is_finite());
        REQUIRE(estimate->covariance.allFinite());
        REQUIRE(estimate->v_world_body.allFinite());
        estimates.push_back(*estimate);
      }
    }
    init = vio->init_report();
    counts = vio->imu().counts();
    begin_s = 1e-9 * double(start);
  }

  /// RMS error of the position from `from` to `to` [s], aligned in position and heading.
  double ate(double from, double to) const {
    io::Trajectory estimated;
    for (const Estimate<double>& estimate : estimates) {
      const double t = 1e-9 * double(estimate.t_ns) - begin_s;
      if (t >= from && t <= to && estimate.health.state != HealthState::initializing)
        estimated.push_back({estimate.t_ns + std::llround(1e9 * estimate.time_offset_s), estimate.T_world_body});
    }
    std::vector<io::PosePair> pairs = io::associate(*recording.read_groundtruth(true), estimated, 0.01);
    const auto S = io::align(pairs, io::Alignment::posyaw);
    REQUIRE(pairs.size() > 20);
    REQUIRE(S);
    for (io::PosePair& pair : pairs) pair.estimate = io::aligned(*S, pair.estimate);
    return io::absolute_error(pairs).translation.rmse;
  }

  double part(HealthState state, double from, double to) const {
    int n = 0, all = 0;
    for (const Estimate<double>& estimate : estimates) {
      const double t = 1e-9 * double(estimate.t_ns) - begin_s;
      if (t < from || t > to) continue;
      ++all;
      n += estimate.health.state == state;
    }
    return all > 0 ? double(n) / all : 0;
  }
};

bool during(double t, double from, double to) { return t >= from && t < to; }

}  // namespace

TEST_CASE("inertial_estimator: initialization in flight", "[data]") {
  if (skip_without(flight)) return;
  const Flight run({});
  CAPTURE(run.ate(0, 14));
  REQUIRE(run.init.stage == InitStage::done);
  REQUIRE(1e-9 * double(run.init.done_ns) - run.begin_s < 2.5);
  REQUIRE(run.ate(0, 14) < 0.10);
  REQUIRE(run.part(HealthState::initializing, 2.5, 14) == 0);
  REQUIRE(run.part(HealthState::tracking, 5.5, 14) == 1);  // once the scale is certain
  // What is known of this sensor: 0.08 rad/s about z.
  REQUIRE((run.estimates.back().bias_gyro - Vec<double, 3>(-0.002, 0.021, 0.077)).norm() < 0.005);
}

TEST_CASE("inertial_estimator: images that stop coming", "[data]") {
  if (skip_without(flight)) return;
  const double pause = GENERATE(0.5, 3.0);
  Trouble trouble;
  trouble.image = [pause](double t, cv::Mat&) { return !during(t, 6, 6 + pause); };
  const Flight run(trouble);
  const double after = run.ate(6 + pause + 0.5, 14), whole = run.ate(0, 14);
  CAPTURE(pause, after, whole);
  REQUIRE(run.part(HealthState::tracking, 6 + pause + 1, 14) > 0.95);
  REQUIRE(after < 0.15);
  REQUIRE(whole < (pause < 1 ? 0.15 : 0.6));  // no jump of the frame
}

TEST_CASE("inertial_estimator: a few black images leave no trace", "[data]") {
  if (skip_without(flight)) return;
  const double outage_s = GENERATE(0.2, 0.3, 0.5);
  Trouble trouble;
  trouble.image = [outage_s](double t, cv::Mat& image) {
    if (during(t, 6, 6 + outage_s)) image.setTo(0);
    return true;
  };
  const Flight run(trouble);
  CAPTURE(outage_s, run.ate(0, 14));
  REQUIRE(run.ate(0, 14) < 0.10);  // that of the whole flight
  REQUIRE(run.part(HealthState::tracking, 6 + outage_s + 0.5, 14) == 1);
}

TEST_CASE("inertial_estimator: a gyroscope whose bias jumps", "[data]") {
  if (skip_without(flight)) return;
  const double step = GENERATE(0.05, 0.3);
  Trouble trouble;
  trouble.imu = [step](double t, ImuSample& sample) {
    if (t >= 6) sample.gyro.x() += step;
    return true;
  };
  const Flight run(trouble);
  CAPTURE(step, run.ate(0, 14));
  REQUIRE(run.ate(0, 14) < 0.10);  // that of the whole flight
  REQUIRE((run.estimates.back().bias_gyro - Vec<double, 3>(-0.002 + step, 0.021, 0.077)).norm() < 0.01);
  REQUIRE(run.part(HealthState::tracking, 10, 14) > 0.95);
}

TEST_CASE("inertial_estimator: images that are repeated", "[data]") {
  if (skip_without(flight)) return;
  Trouble trouble;
  cv::Mat last;
  trouble.image = [&last](double t, cv::Mat& image) {
    if (during(t, 6, 7)) image = last.clone();
    last = image;
    return true;
  };
  const Flight run(trouble);
  CAPTURE(run.ate(0, 14));
  REQUIRE(run.part(HealthState::tracking, 6.01, 6.99) == 0);
  REQUIRE(run.ate(0, 14) < 0.15);
  REQUIRE(run.part(HealthState::tracking, 8, 14) > 0.95);
}

TEST_CASE("inertial_estimator: two seconds of black images are bridged by the IMU and marked as degraded", "[data]") {
  if (skip_without(flight)) return;
  Trouble trouble;
  trouble.image = [](double t, cv::Mat& image) {
    if (during(t, 6, 8)) image.setTo(0);
    return true;
  };
  const Flight run(trouble);
  const double after = run.ate(8.5, 14), whole = run.ate(0, 14);
  CAPTURE(after, whole);
  REQUIRE(run.part(HealthState::tracking, 6.1, 7.9) == 0);
  REQUIRE(run.part(HealthState::tracking, 10, 14) > 0.95);
  REQUIRE(after < 0.15);
  REQUIRE(whole < 0.4);
}

TEST_CASE("inertial_estimator: samples out of order, all before their frame, change nothing", "[data]") {
  if (skip_without(flight)) return;
  Trouble trouble;
  trouble.duration_s = 5;
  const Flight in_order(trouble);
  trouble.shuffled = 5;
  const Flight run(trouble);
  REQUIRE(in_order.counts.reordered == 0);
  REQUIRE((run.counts.reordered > 300 && run.counts.late == 0 && run.counts.repeated == 0));
  REQUIRE(run.init.stage == InitStage::done);
  REQUIRE(run.estimates.size() == in_order.estimates.size());
  for (std::size_t k = 0; k < run.estimates.size(); ++k) {
    REQUIRE(run.estimates[k].T_world_body.R() == in_order.estimates[k].T_world_body.R());
    REQUIRE(run.estimates[k].T_world_body.p() == in_order.estimates[k].T_world_body.p());
    REQUIRE(run.estimates[k].covariance == in_order.estimates[k].covariance);
  }
}

TEST_CASE("inertial_estimator: samples that are missing, repeated, late, NaN or saturated", "[data]") {
  if (skip_without(flight)) return;
  const int kind = GENERATE(0, 1, 2, 3, 4, 5);
  Trouble trouble;
  int count = 0;
  TimeNs before = 0;
  trouble.imu = [kind, &count, &before](double t, ImuSample& sample) {
    const bool third = ++count % 3 == 0;
    if (kind == 0) return !during(t, 6, 6.2);
    if (kind == 1 && during(t, 6, 7) && third) sample.t_ns = before;        // repeats a time
    if (kind == 4 && during(t, 6, 7) && third) sample.t_ns -= 163'000'000;  // as if it came long after its frame
    before = sample.t_ns;
    if (kind == 2 && during(t, 6, 6.1)) sample.accel.setConstant(std::nan(""));
    if (kind == 3 && during(t, 6, 6.3)) sample.gyro.setConstant(1e3), sample.accel.setConstant(-1e3);
    if (kind == 5 && during(t, 6, 7)) sample.accel.z() = 1e3;
    return true;
  };
  const Flight run(trouble);
  const double after = run.ate(7.5, 14), whole = run.ate(0, 14);
  CAPTURE(kind, after, whole, run.counts.late, run.counts.repeated, run.counts.not_finite, run.counts.saturated);
  if (kind == 1) REQUIRE(run.counts.repeated > 60);
  REQUIRE((kind == 4 ? run.counts.late > 60 : run.counts.late == 0));
  if (kind == 2) REQUIRE(run.counts.not_finite > 10);
  if (kind == 3 || kind == 5) REQUIRE(run.counts.saturated > 50);
  REQUIRE(run.part(HealthState::tracking, 8, 14) > 0.95);
  REQUIRE(after < 0.10);
  REQUIRE(whole < 0.10);
  if (kind == 3) {
    REQUIRE(run.part(HealthState::tracking, 6.01, 6.3) == 0);
    REQUIRE(run.part(HealthState::degraded, 6.01, 6.3) == 1);
  }
}

TEST_CASE("inertial_estimator: samples of another body end in a reset", "[data]") {
  if (skip_without(flight)) return;
  Trouble trouble;
  trouble.duration_s = 26;
  trouble.imu = [](double t, ImuSample& sample) {
    if (during(t, 5, 9)) {
      sample.gyro = -2 * sample.gyro;
      std::swap(sample.accel.y(), sample.accel.z());
    }
    return true;
  };
  const Flight run(trouble);
  CAPTURE(run.estimates.back().resets, run.init.rejected);
  REQUIRE(run.part(HealthState::tracking, 5.5, 9) == 0);
  REQUIRE(run.part(HealthState::lost, 7, 9) > 0);
  REQUIRE(run.estimates.back().resets == 1);
  REQUIRE(run.part(HealthState::lost, 15.5, 26) == 0);
  REQUIRE(run.part(HealthState::tracking, 25, 26) == 1);
}

TEST_CASE("inertial_estimator: an initialization inconsistent with the IMU is rejected by scale verification",
          "[data]") {
  if (skip_without(flight)) return;
  Trouble trouble;
  trouble.imu = [](double t, ImuSample& sample) {
    if (during(t, 2, 3)) sample.gyro = -2 * sample.gyro;
    return true;
  };
  trouble.duration_s = 20;
  const Flight run(trouble);
  const auto reset =
      std::find_if(run.estimates.begin(), run.estimates.end(), [](const auto& x) { return x.resets > 0; });
  REQUIRE(reset != run.estimates.end());
  const double reset_s = 1e-9 * double(reset->t_ns) - run.begin_s;
  CAPTURE(reset_s, run.init.rejected);
  CHECK(reset_s > 2.4);
  CHECK(reset_s < 3.2);
  CHECK(reset->health.state == HealthState::lost);
  // Of the way so far nothing is known, the body may have moved by a meter a second; its heading is the gyroscope's.
  CHECK(std::sqrt(reset->covariance(3, 3)) > 1);
  CHECK(std::sqrt(reset->covariance(2, 2)) > 0.02);
  CHECK(run.estimates.back().resets == 1);
  CHECK(run.init.rejected >= 1);
  CHECK(run.part(HealthState::tracking, 2.4, 4) == 0);
  CHECK(run.part(HealthState::tracking, 17, 20) == 1);
}

TEST_CASE("inertial_estimator: the scale is uncertain as long as it is badly observable", "[data]") {
  if (skip_without(flight)) return;
  Trouble trouble;
  const bool bad = GENERATE(false, true);
  if (bad) trouble.noise_scale = 30;
  const Flight run(trouble);
  CAPTURE(bad);
  CHECK(run.part(HealthState::tracking, 8, 14) == (bad ? 0 : 1));
  if (bad) CHECK(run.estimates.back().health.reason == HealthReason::scale_uncertain);
}

TEST_CASE("inertial_estimator: wrong extrinsics are detected", "[data]") {
  if (skip_without(flight)) return;
  Trouble trouble;
  trouble.T_cam_wrong = SE3<double>(SO3<double>::exp({0, 0, 1.5708}), Vec<double, 3>::Zero());
  trouble.duration_s = 8;
  const Flight run(trouble);
  CAPTURE(name_of(run.init.stage), name_of(run.init.alignment), run.init.gyro_residual, run.init.gravity_norm);
  REQUIRE(run.init.stage != InitStage::done);
  REQUIRE(run.part(HealthState::tracking, 0, 8) == 0);
}

TEST_CASE("inertial_estimator: an error of the extrinsics of degrees and decimeters is estimated", "[data]") {
  if (skip_without(flight)) return;
  const bool wrong = GENERATE(false, true);
  Trouble trouble;
  if (wrong) trouble.T_cam_wrong = SE3<double>(SO3<double>::exp({0.03, -0.02, 0.03}), {-0.15, 0.1, 0.1});
  const Flight run(trouble);
  const Vec<double, 6> off = minus(run.estimates.back().T_body_cam, *run.recording.calibration().T_body_camera);
  CAPTURE(wrong, off.transpose(), run.ate(0, 14));
  REQUIRE(off.head<3>().norm() < 6e-3);
  REQUIRE(off.tail<3>().norm() < 0.06);
  REQUIRE(run.part(HealthState::tracking, 8, 14) > 0.9);
  REQUIRE(run.ate(0, 14) < 0.13);
}

TEST_CASE("inertial_estimator: a time offset of 15 ms is corrected", "[data]") {
  if (skip_without(flight)) return;
  Trouble trouble;
  trouble.camera_offset_s = GENERATE(-0.015, 0.015);
  const Flight run(trouble);
  const double found_s = run.estimates.back().time_offset_s;
  CAPTURE(trouble.camera_offset_s, found_s, run.ate(0, 14));
  REQUIRE(std::abs(found_s + trouble.camera_offset_s) < 3e-3);
  const auto initialized = std::find_if(run.estimates.begin(), run.estimates.end(),
                                        [&](const auto& x) { return x.t_ns == run.init.done_ns; });
  REQUIRE(initialized != run.estimates.end());
  CAPTURE(1e-9 * double(initialized->t_ns) - run.begin_s, initialized->time_offset_s, run.init.rejected);
  REQUIRE(std::abs(initialized->time_offset_s + trouble.camera_offset_s) <
          6e-3);  // its scale is one with that time offset
  REQUIRE(run.part(HealthState::tracking, 10, 14) > 0.9);
  REQUIRE(run.ate(0, 14) < 0.15);
}

TEST_CASE("inertial_estimator: a texture that moves over half of the image", "[data]") {
  if (skip_without(flight)) return;
  Trouble trouble;
  trouble.image = [](double t, cv::Mat& image) {
    if (!during(t, 6, 9)) return true;
    for (int y = 0; y < image.rows; ++y) {  // squares of 24 px with corners, 60 px/s to the right
      for (int x = image.cols / 2; x < image.cols; ++x) {
        const int u = x - static_cast<int>(60 * t), cell = (u / 24) * 7 + (y / 24) * 13;
        image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(60 + (cell * cell) % 130);
      }
    }
    return true;
  };
  const Flight run(trouble);
  const double after = run.ate(9.5, 14), whole = run.ate(0, 14);
  CAPTURE(after, whole);
  REQUIRE(run.part(HealthState::lost, 0, 14) == 0);
  REQUIRE(run.part(HealthState::tracking, 12, 14) >
          0.95);  // a gyroscope inconsistent with the images is suspect for 3 s
  REQUIRE(after < 0.15);
  REQUIRE(whole < 0.3);
}
