// The IMU of real flights against their truth: propagation, re-integration, initialization with simulated vision.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "catch.hpp"
#include "plumbline/imu/alignment.hpp"
#include "plumbline/imu/imu_buffer.hpp"
#include "plumbline/imu/preintegration.hpp"
#include "plumbline/imu/stationarity.hpp"
#include "plumbline/io/text.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

const std::filesystem::path imu_only = std::filesystem::path(PLUMBLINE_TEST_DATA) / "imu_only";

struct Flight {
  struct Truth {
    TimeNs t_ns;
    NavState<double> x;
  };
  std::vector<ImuSample> imu;
  std::vector<Truth> truth;  ///< 200 Hz

  explicit Flight(const std::string& name) {
    const std::filesystem::path mav = imu_only / name / "mav0";
    for (io::RowReader row(mav / "imu0/data.csv"); row.next();) {
      imu.push_back({row.time_in_nanoseconds(), columns(row, 1), columns(row, 4)});
    }
    for (io::RowReader row(mav / "state_groundtruth_estimate0/data.csv"); row.next();) {
      const Eigen::Quaterniond q(row.number(4), row.number(5), row.number(6), row.number(7));
      truth.push_back(
          {row.time_in_nanoseconds(),
           {SE3<double>(SO3<double>(q), columns(row, 1)), columns(row, 8), columns(row, 11), columns(row, 14)}});
    }
  }

  /// The samples around that time.
  ImuBuffer<1024> buffer(TimeNs begin, TimeNs end) const {
    ImuBuffer<1024> out;
    auto sample = std::lower_bound(imu.begin(), imu.end(), begin - 10'000'000,
                                   [](const ImuSample& s, TimeNs t) { return s.t_ns < t; });
    for (; sample != imu.end() && sample->t_ns < end + 10'000'000; ++sample) REQUIRE(out.add(*sample));
    return out;
  }

 private:
  static Vec<double, 3> columns(const io::RowReader& row, std::size_t i) {
    return {row.number(i), row.number(i + 1), row.number(i + 2)};
  }
};

double quantile(std::vector<double> values, double q) {
  REQUIRE(!values.empty());
  std::sort(values.begin(), values.end());
  return values[std::size_t(q * double(values.size() - 1))];
}

constexpr double deg = 180 / std::numbers::pi;
const Vec<double, 3> gravity = gravity_in_world<double>();

}  // namespace

TEMPLATE_TEST_CASE("real_imu: propagation from the truth", "[data]", float, double) {
  if (skip_without(imu_only)) return;
  using S = TestType;
  struct Expected {  // median, 95 %
    double duration, rotation_deg[2], velocity[2], position[2];
  };
  const auto run = [](const Flight& flight, const Expected& expected) {
    std::vector<double> rotation, velocity, position;
    const std::size_t rows = std::size_t(std::lround(expected.duration * 200));
    for (std::size_t i = 0; i + rows < flight.truth.size(); i += 50) {
      const Flight::Truth &begin = flight.truth[i], &end = flight.truth[i + rows];
      ImuIncrement<S> increment(begin.x.bias_gyro.cast<S>(), begin.x.bias_accel.cast<S>());
      const ImuCoverage coverage = flight.buffer(begin.t_ns, end.t_ns)
                                       .for_each_interval(begin.t_ns, end.t_ns, [&](const ImuInterval<double>& d) {
                                         increment.integrate(d.cast<S>(), ImuNoise{});
                                       });
      REQUIRE((coverage.valid && coverage.missing() == 0));
      const NavState<double> x = increment.predict(begin.x.cast<S>(), gravity.cast<S>()).template cast<double>();
      const Vec<double, 15> error = minus(x, end.x);
      rotation.push_back(error.head<3>().norm() * deg);
      position.push_back(error.segment<3>(3).norm());
      velocity.push_back(error.segment<3>(6).norm());
    }
    const auto check = [&](const std::vector<double>& errors, const double(&limits)[2]) {
      CAPTURE(expected.duration, quantile(errors, 0.5), quantile(errors, 0.95));
      for (int k = 0; k < 2; ++k) CHECK(quantile(errors, k == 0 ? 0.5 : 0.95) < 1.1 * limits[k]);
    };
    check(rotation, expected.rotation_deg);
    check(velocity, expected.velocity);
    check(position, expected.position);
  };
  const Flight room("euroc_V1_02_medium"), hall("euroc_MH_04_difficult");
  run(room, {0.05, {0.006, 0.022}, {0.003, 0.006}, {0.0001, 0.0002}});
  run(room, {0.25, {0.026, 0.069}, {0.014, 0.027}, {0.002, 0.004}});
  run(room, {1, {0.08, 0.18}, {0.043, 0.093}, {0.024, 0.046}});
  run(room, {3, {0.17, 0.40}, {0.10, 0.20}, {0.17, 0.33}});
  run(hall, {0.05, {0.001, 0.003}, {0.0022, 0.011}, {0.00014, 0.0009}});
  run(hall, {0.25, {0.0044, 0.010}, {0.013, 0.039}, {0.0024, 0.008}});
  run(hall, {1, {0.02, 0.04}, {0.037, 0.090}, {0.022, 0.060}});
  run(hall, {3, {0.06, 0.11}, {0.06, 0.13}, {0.12, 0.27}});
}

TEST_CASE("real_imu: merged samples integrate to the same motion", "[data]") {
  if (skip_without(imu_only)) return;
  for (const char* name : {"euroc_V1_02_medium", "euroc_MH_04_difficult"}) {
    const Flight flight(name);
    std::vector<double> rotation, velocity, position;
    for (std::size_t i = 0; i + 200 < flight.truth.size(); i += 100) {
      Preintegration<double, 128> merged;  // 200 samples in 128 intervals
      const TimeNs begin = flight.truth[i].t_ns, end = flight.truth[i + 200].t_ns;
      flight.buffer(begin, end).for_each_interval(begin, end, [&](const ImuInterval<double>& d) { merged.add(d); });
      const ImuIncrement<double>::Delta all = merged.increment().delta;
      merged.reintegrate(Vec<double, 3>::Zero(), Vec<double, 3>::Zero());
      rotation.push_back(minus(merged.increment().delta.dR, all.dR).norm() * deg);
      velocity.push_back((merged.increment().delta.dv - all.dv).norm());
      position.push_back((merged.increment().delta.dp - all.dp).norm());
    }
    CAPTURE(name, quantile(rotation, 0.95), quantile(velocity, 0.95), quantile(position, 0.95));
    REQUIRE(quantile(rotation, 0.95) < 0.01);  // a tenth of what the IMU itself is wrong by in that second
    REQUIRE(quantile(velocity, 0.95) < 0.01);
    REQUIRE(quantile(position, 0.95) < 0.01);
  }
}

TEST_CASE("real_imu: stationarity", "[data]") {
  if (skip_without(imu_only)) return;
  std::vector<double> gyro, tilt_deg;
  for (const char* name : {"euroc_V1_02_medium", "euroc_MH_04_difficult"}) {
    const Flight flight(name);
    for (std::size_t i = 200; i < flight.truth.size(); i += 20) {
      const Flight::Truth& truth = flight.truth[i];
      const StationarityReport report = stationarity(flight.buffer(truth.t_ns - 1'000'000'000, truth.t_ns), truth.t_ns);
      if (!report.is_stationary()) continue;
      CAPTURE(name, i, report.gyro_spread, report.accel_spread);
      REQUIRE(truth.x.v_world_body.norm() < 0.05);
      REQUIRE((truth.x.T_world_body.p() - flight.truth[i - 200].x.T_world_body.p()).norm() < 0.02);
      const NavState<double> x = stationary_state<double>(report);
      const Vec<double, 3> down(0, 0, -1);
      gyro.push_back((x.bias_gyro - truth.x.bias_gyro).norm());
      tilt_deg.push_back(
          (x.T_world_body.rotation() * (truth.x.T_world_body.rotation().inverse() * down) - down).norm() * deg);
    }
  }
  CAPTURE(gyro.size(), quantile(gyro, 0.5), quantile(gyro, 1), quantile(tilt_deg, 0.5), quantile(tilt_deg, 1));
  REQUIRE(gyro.size() > 20);
  REQUIRE((quantile(gyro, 0.5) < 0.002 && quantile(gyro, 1) < 0.012));      // 0.012 is the limit of the spread
  REQUIRE((quantile(tilt_deg, 0.5) < 1.2 && quantile(tilt_deg, 1) < 1.5));  // 0.15 m/s^2 of accelerometer bias
}

TEST_CASE("real_imu: initialization from noisy camera poses", "[data]") {
  if (skip_without(imu_only)) return;
  using Frame = AlignmentFrame<Preintegration<double>>;
  struct Errors {
    std::vector<double> scale, gravity_deg, gyro, velocity;
  };
  constexpr std::size_t count = 10, step = 50;  // ten frames, 0.25 s apart
  const SE3<double> T_body_cam(SO3<double>::exp({0.4, -1.2, 0.9}), {-0.02, -0.06, 0.01});
  const ImuNoise noise{3e-4, 1.6e-2, 2e-5, 3e-3, 200};  // in flight: rotors shake the sensor
  for (const char* name : {"euroc_V1_02_medium", "euroc_MH_04_difficult"}) {
    const Flight flight(name);
    for (const auto& [metric, off] : {std::pair{false, false}, {true, false}, {false, true}, {true, true}}) {
      const double scale = metric ? 1 : 2.5;
      const Vec<double, 3> offset = off ? Vec<double, 3>(0.5, -0.3, 0.4) : Vec<double, 3>::Zero();
      const InertialAlignmentOptions options{
          .metric = metric, .rotation_sigma = 1e-3, .position_sigma = 4e-3 / scale};  // 4 mm
      testing::Gaussian normal(1);
      Errors errors;
      std::map<AlignmentOutcome, int> outcomes;
      int tried = 0;
      for (std::size_t i = 0; i + step * (count - 1) < flight.truth.size(); i += 100, ++tried) {
        const SO3<double> R_ref_world = SO3<double>::exp(normal.vector<3>());
        std::vector<Preintegration<double>> imu(count, Preintegration<double>(noise));
        std::vector<Frame> frames;
        for (std::size_t k = 0; k < count; ++k) {
          const TimeNs t = flight.truth[i + step * k].t_ns, before = flight.truth[i + step * (k - (k > 0))].t_ns;
          flight.buffer(before, t).for_each_interval(before, t, [&](ImuInterval<double> d) {
            d.accel_begin += offset;
            d.accel_end += offset;
            imu[k].add(d);
          });
          const SE3<double> T_world_cam = flight.truth[i + step * k].x.T_world_body * T_body_cam;
          Vec<double, 6> error;
          error << options.rotation_sigma * normal.vector<3>(), options.position_sigma * normal.vector<3>();
          frames.push_back({plus(SE3<double>(R_ref_world * T_world_cam.rotation(),
                                             R_ref_world * Vec<double, 3>(T_world_cam.p() / scale)),
                                 error),
                            &imu[k]});
        }
        const InertialAlignment<double, int(count)> a =
            align_inertial<int(count)>(std::span<const Frame>(frames), T_body_cam, options);
        ++outcomes[a.outcome];
        if (!a) continue;
        const NavState<double>& first = flight.truth[i].x;
        const NavState<double>& last = flight.truth[i + step * (count - 1)].x;
        const SO3<double> yaw = a.R_world_ref * R_ref_world;
        const Vec<double, 3> e3 = Vec<double, 3>::UnitZ();
        errors.scale.push_back(std::abs(a.scale / scale - 1));
        errors.gravity_deg.push_back((yaw * e3 - e3).norm() * deg);
        errors.gyro.push_back((a.bias_gyro - first.bias_gyro).norm());
        errors.velocity.push_back((a.v_world_body[count - 1] - yaw * last.v_world_body).norm());
      }
      CAPTURE(name, metric, off, tried, outcomes[AlignmentOutcome::aligned]);
      CAPTURE(quantile(errors.scale, 0.5), quantile(errors.scale, 0.95), quantile(errors.scale, 1));
      CAPTURE(quantile(errors.gravity_deg, 0.5), quantile(errors.gravity_deg, 0.95), quantile(errors.gravity_deg, 1));
      CAPTURE(quantile(errors.gyro, 0.5), quantile(errors.gyro, 0.95));
      CAPTURE(quantile(errors.velocity, 0.5), quantile(errors.velocity, 0.95));
      REQUIRE(outcomes[AlignmentOutcome::aligned] > (metric ? 0.95 : 0.6) * tried);
      REQUIRE((quantile(errors.scale, 0.5) < 0.05 && quantile(errors.scale, 0.95) < 0.15));
      // An offset of 0.7 m/s^2 not separated from gravity would be 4 degrees.
      REQUIRE(quantile(errors.gravity_deg, 0.5) < (off ? 3.5 : 1));
      REQUIRE(quantile(errors.gravity_deg, 0.95) < (off ? 4.5 : 1.8));
      REQUIRE((quantile(errors.gyro, 0.5) < 0.002 && quantile(errors.gyro, 0.95) < 0.005));
      REQUIRE((quantile(errors.velocity, 0.5) < 0.06 && quantile(errors.velocity, 0.95) < (off ? 0.25 : 0.2)));
    }
  }
}
