#pragma once
/// plumbline.Estimator: one configuration of the program, fed sample by sample.

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>

#include <pybind11/pybind11.h>

#include "arrays.hpp"
#include "plumbline/io/calibration_data.hpp"
#include "runner.hpp"

/// A sample or a frame that the estimator does not use; it stays usable.
struct Refused : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class PythonEstimator {
 public:
  struct Options {
    std::optional<std::filesystem::path> imu_calibration;  ///< instead of the calibration's
    double depth_scale = 0;                                ///< instead of the calibration's; 0: as it is
    bool with_map = false;
  };

  PythonEstimator(const std::string& config, const std::filesystem::path& calibration, const Options& options);

  /// One sample or many. All are given to the estimator; throws Refused where it does not use one.
  void add_imu(const pybind11::object& t_ns, const pybind11::object& gyro, const pybind11::object& accel);
  /// Throws Refused.
  FrameOutput add_frame(plumbline::TimeNs t_ns, const pybind11::array& gray,
                        const std::optional<pybind11::array>& depth);

  /// Of the latest frame; nothing before the first one.
  std::optional<FrameOutput> state() const;
  plumbline::HealthState health() const;
  pybind11::array_t<double> landmarks() const;
  double time_offset_s() const;
  const char* config() const { return configuration_.name; }

 private:
  /// The work without Python's lock, by one thread at a time.
  template <class Work>
  auto locked(Work&& work) const {
    const pybind11::gil_scoped_release release;
    const std::lock_guard lock(mutex_);
    return work();
  }

  const Configuration& configuration_;
  plumbline::io::Calibration calibration_;
  std::unique_ptr<Runner> runner_;
  std::optional<FrameOutput> latest_;
  mutable std::mutex mutex_;
};
