#pragma once
/// Many runs of one recording, each spoiled in another way: the recording in memory, a run, and how it went.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "plumbline/core/time.hpp"
#include "plumbline/imu/sample.hpp"
#include "plumbline/io/calibration_data.hpp"
#include "plumbline/io/trajectory.hpp"
#include "plumbline/lie/so3.hpp"
#include "recording_options.hpp"
#include "runner.hpp"

struct Picture {
  plumbline::TimeNs t_ns;
  cv::Mat gray, depth;  ///< `depth` is empty where there is none
};
using Event = std::variant<plumbline::ImuSample, Picture>;

struct LoadedRecording {
  std::string name;
  plumbline::io::Calibration calibration;
  plumbline::io::Trajectory truth;             ///< of what a run estimates: body with an IMU, camera without
  std::vector<Event> events;                   ///< in order of time
  std::vector<std::string> notes;              ///< what is said of its files and of sensors that are not used
  plumbline::TimeNs begin_ns = 0, end_ns = 0;  ///< first and last frame
  bool with_map = false;                       ///< the estimator has a map, and poses are those in it
};

/// Throws std::runtime_error where the recording lacks what is needed, or truth.
LoadedRecording load_recording(const std::filesystem::path& directory, const Configuration& configuration,
                               const RecordingOptions& inputs);

/// Changes an event; false: it is left out.
using Spoil = std::function<bool(Event&)>;

/// A frame of a run beside the truth.
struct JudgedFrame {
  plumbline::TimeNs t_ns;
  plumbline::Estimate<double> estimate;
  double error_m = 0;  ///< after aligning all poses; NaN where there is no sound pose or no truth
  double position_sigmas = 0, rotation_sigmas = 0;  ///< of the error since the first pose, by the covariance
  /// `tracking` promises that the truth is within 3 sigma: 99.7 % of three degrees of freedom.
  bool is_false() const;
};

struct Trial {
  std::vector<JudgedFrame> frames;
  plumbline::SO3<double> heading;  ///< of the truth, see TruthComparison
};

/// Gives the events from begin_ns to end_ns to a runner, pictures once their IMU samples are there; `use` gets what
/// comes of each picture.
void run_events(Runner& runner, const LoadedRecording& recording, plumbline::TimeNs begin_ns, plumbline::TimeNs end_ns,
                const Spoil& spoil, const std::function<void(const FrameOutput&)>& use);

/// Runs the events from begin_ns to end_ns. `heading`: that of a run that went well; this one may go astray.
Trial run_trial(const Configuration& configuration, const LoadedRecording& recording, plumbline::TimeNs begin_ns,
                plumbline::TimeNs end_ns, const Spoil& spoil,
                const std::optional<plumbline::SO3<double>>& heading = std::nullopt);

/// Root mean square of the errors [m]; NaN of no poses.
double ate_of(const std::vector<JudgedFrame>& frames);
