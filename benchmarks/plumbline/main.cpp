// The program `plumbline`: every configuration of the estimator on recordings, and what goes with it.
#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "calibration_command.hpp"
#include "compare.hpp"
#include "convert.hpp"
#include "doctor.hpp"
#include "evaluate.hpp"
#include "faults.hpp"
#include "interrupt.hpp"
#include "live.hpp"
#include "memory.hpp"
#include "misuse.hpp"
#include "nearest.hpp"
#include "number_range.hpp"
#include "plumbline/io/printable.hpp"
#include "relocalizations.hpp"
#include "results.hpp"
#include "run.hpp"
#include "runner.hpp"
#include "saved_map.hpp"
#include "simulate.hpp"
#include "starts.hpp"

namespace {

constexpr double longest_s = 1e7;  // four months
constexpr int misused = 2;         // exit status

/// Throws at the first misspelled command or option, with the name that was probably meant.
void check_names(const CLI::App& app, std::span<const std::string> arguments) {
  if (arguments.empty() || arguments[0].starts_with('-')) return;
  std::vector<std::string> known;
  const CLI::App* command = nullptr;
  for (const CLI::App* each : app.get_subcommands(nullptr)) {
    if (each->get_name() == arguments[0]) command = each;
    known.push_back(each->get_name());
  }
  if (command == nullptr) throw Misuse(unknown_name("command", arguments[0], known));

  known.clear();
  for (const CLI::Option* option : command->get_options())
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  for (const std::string& argument : arguments.subspan(1)) {
    const std::string name(argument.substr(0, argument.find('=')));
    if (name.starts_with("--") && std::find(known.begin(), known.end(), name) == known.end())
      throw Misuse(unknown_name("option", name, known));
  }
}

/// What the parser says of a command line, in the program's words.
std::string wording_of(const CLI::ParseError& error) {
  std::string text = error.what();
  if (text.starts_with("The following argument")) return text.substr(text.rfind(": ") + 2) + ": not expected here";
  if (error.get_name() == "ArgumentMismatch") return text.substr(0, text.find(": ")) + ": its value is missing";
  if (text == "A subcommand is required") return "a command is required, see plumbline --help";
  return text;
}

/// `help` and `help COMMAND` as --help.
std::vector<std::string> arguments_of(int argc, char* argv[]) {
  std::vector<std::string> out(argv + 1, argv + argc);
  if (!out.empty() && out[0] == "help") {
    out.erase(out.begin());
    out.emplace_back("--help");
  }
  return out;
}

struct ListOptions {
  bool memory = false;
  ResultOptions results;
};

int list(const ListOptions& options) {
  if (options.memory) return list_memory(options.results);

  for (const Configuration& configuration : configurations()) {
    const Needs& needs = configuration.needs;
    const std::string sensors = std::string("camera") + (needs.depth ? ", depth" : "") + (needs.imu ? ", IMU" : "");
    const bool is_recommended = &configuration == &recommended_for(needs);
    std::printf("%-34s needs %-20s%s\n", configuration.name, sensors.c_str(),
                is_recommended ? "recommended for these" : "");
  }
  return 0;
}

void add_results(CLI::App& command, ResultOptions& options) {
  command.add_option("--json", options.json, "All figures to write, JSON");
  command.add_option("--markdown", options.markdown, "Table to write, Markdown");
  command.add_option("--commit", options.commit, "Commit of the source, for these files")->envname("PLUMBLINE_COMMIT");
}

void add_list(CLI::App& app, ListOptions& options) {
  CLI::App* command =
      app.add_subcommand("list", "Print the names of the configurations, and the sensors that each needs");
  command->add_flag("--memory", options.memory, "Print the size of each estimator with the types of firmware");
  add_results(*command, options.results);
  for (const char* name : {"--json", "--markdown"}) command->get_option(name)->needs("--memory");
}

void add_table(CLI::App& app, TableOptions& options) {
  CLI::App* command = app.add_subcommand("table", "Write the tables of results that other commands left as JSON");
  command->add_option("files", options.files, "Files of starts, faults, relocalizations, compare or list --memory")
      ->required();
  command->add_option("--template", options.page, "Page with marks where tables go: <!-- table NAME -->");
  command->add_option("--command", options.command, "Command that made a comparison, for its table");
  add_results(*command, options.outputs);
}

void add_topics(CLI::App& command, TopicOptions& topics) {
  const std::string of_bag = " of a bag; the only one by default, none: without";
  command.add_option("--image-topic", topics.image, "Topic of the images of a bag; the only one by default");
  command.add_option("--depth-topic", topics.depth, "Topic of the depth images" + of_bag);
  command.add_option("--imu-topic", topics.imu, "Topic of the IMU samples" + of_bag);
  command.add_option("--camera-info-topic", topics.camera_info,
                     "Topic of the calibration of a bag; that beside the images");
}

void add_convert(CLI::App& app, ConvertOptions& options) {
  CLI::App* command = app.add_subcommand("convert", "Write a bag as a folder: EuRoC or TUM layout");
  command->add_option("bag", options.bag, "Bag: ROS 1, MCAP or SQLite, or a folder of ROS 2")->required();
  command->add_option("out", options.out, "Folder to make")->required();
  command->add_option("--layout", options.layout, "euroc or tum; with depth tum, else euroc by default")
      ->check(CLI::IsMember({"euroc", "tum"}));
  add_topics(*command, options.topics);
  command->add_option("--calibration", options.calibration, "Calibration instead of the bag's own");
  command->add_option("--imu-calibration", options.imu_calibration, "Noise of the IMU");
  command->add_option("--start", options.start_s, "Begin this long after the first frame [s]")
      ->check(number_from(0, longest_s, "s"));
  command->add_option("--duration", options.duration_s, "Length of the part to write [s]")
      ->check(number_from(0.001, longest_s, "s"));
}

void add_inputs(CLI::App& command, RecordingOptions& options) {
  command.add_option("--calibration", options.calibration, "Calibration instead of the recording's own");
  command.add_option("--imu-calibration", options.imu_calibration,
                     "Noise of the IMU (Kalibr imu.yaml), instead of the calibration's");
  command.add_option("--depth-scale", options.depth_scale, "Raw depth units per meter, instead of the calibration's")
      ->check(number_from(1, 1e6, "units per meter"));
  command
      .add_option("--time-offset", options.time_offset_s,
                  "IMU time = time stamp of an image + this [s], instead of the calibration's")
      ->check(number_from(-3600, 3600, "s"));
  command.add_option("--mask", options.mask,
                     "Gray image of the size of the images, zero where they do not show the scene (a bonnet, legs)");
  command
      .add_option("--scale", options.image_scale,
                  "Scale of the images, e.g. 0.5 (default: 1, or 1/2, 1/3, ... for images that are too large)")
      ->check(number_from(0.01, 1, ""));
  add_topics(command, options.topics);
}

void add_run(CLI::App& app, RunOptions& options) {
  CLI::App* command = app.add_subcommand("run", "Run one configuration on one recording");
  command->add_option("--config", options.config,
                      "Configuration, one of `plumbline list`; the one that fits the recording by default");
  command->footer(
      "Examples:\n"
      "  plumbline run MH_01_easy --trajectory out.tum\n"
      "  plumbline run my_recording --config mono-imu/points/window --calibration camchain.yaml --debug pictures\n"
      "  plumbline run my_drive --calibration camchain.yaml --mask bonnet.png");
  command
      ->add_option("dataset,--dataset", options.dataset, "Folder of the recording (EuRoC, TUM RGB-D, KITTI), or a bag")
      ->required();
  command->add_option("--trajectory", options.files.trajectory, "Trajectory to write, TUM format");
  command->add_option("--timing", options.files.timing, "Times, health and sigmas of each frame to write, CSV");
  command->add_option("--states", options.files.states,
                      "Pose, velocity, biases, covariance and readout time of each frame to write, CSV");
  command->add_flag("--map", options.with_map, "Recognize places and close loops; poses are those in the map");
  command->add_option("--save-map", options.files.map, "Map to write at the end of the run");
  CLI::Option* load = command->add_option("--load-map", options.loaded_map,
                                          "Saved map to begin with; poses are written from where it is recognized on");
  command->add_flag("--localize", options.localize_only, "The loaded map is not changed")->needs(load);
  command->add_option("--trajectory-world", options.files.world,
                      "Trajectory to write in the world, which no loop moves; TUM format");
  command->add_option("--trajectory-final", options.files.final,
                      "Trajectory to write as the map has it at the end of the run; TUM format");
  command->add_option("--loops", options.files.loops,
                      "Loops of the map to write: pose of the body at the later time in that at the earlier one, CSV");
  command->add_flag("--all-poses", options.all_poses,
                    "Poses while lost, and of uncertain scale before initialization, too");
  command->add_option("--landmarks", options.files.landmarks, "Points of the final map to write, PLY");
  command->add_flag("--unchecked", options.is_unchecked, "Run although the recording looks wrong");
  add_inputs(*command, options.inputs);
  CLI::Option* debug = command->add_option(
      "--debug", options.debug.directory,
      "Folder to make (or empty) for pictures of the frames with their features, tables and report.html");
  command->add_option("--debug-every", options.debug.every, "Pictures of every n-th frame")
      ->check(whole_number_from(1, 1e6))
      ->needs(debug);
  command
      ->add_option("--reference", options.debug.reference,
                   "True trajectory for the errors in the debug folder, instead of the recording's own")
      ->needs(debug);
  command->add_option("--start", options.start_s, "Begin this long after the first frame [s]")
      ->check(number_from(0, longest_s, "s"));
  command->add_option("--duration", options.duration_s, "Length of the part to run [s]")
      ->check(number_from(0.001, longest_s, "s"));
}

void add_live(CLI::App& app, LiveOptions& options) {
  CLI::App* command = app.add_subcommand("live", "Run one configuration on frames and IMU samples as they come");
  command->footer(
      "Examples:\n"
      "  examples/python/live_client.py room | plumbline live --config rgbd/points/window --wait\n"
      "  plumbline live --config mono-imu/points/window --calibration camchain.yaml --listen 4711");
  command->add_option("--config", options.config, "Configuration, one of `plumbline list`")->required();
  command->add_option("--calibration", options.calibration, "Calibration instead of the stream's");
  command->add_option("--imu-calibration", options.imu_calibration, "Noise of the IMU, beside --calibration");
  command->add_option("--mask", options.mask,
                      "Gray image of the size of the images, zero where they do not show the scene (a bonnet, legs)");
  command->add_option("--depth-scale", options.depth_scale, "Raw depth units per meter, instead of the calibration's")
      ->check(number_from(1, 1e6, "units per meter"));
  command->add_option("--listen", options.address,
                      "Port of 127.0.0.1 or path of a Unix socket for one sender, who gets the estimates, too; instead "
                      "of standard input and output");
  command
      ->add_option("--format", options.format,
                   "Estimates as json (lines) or binary (messages); binary-map: with messages about the map")
      ->check(CLI::IsMember({"json", "binary", "binary-map"}))
      ->capture_default_str();
  command->add_flag("--wait", options.sender_waits, "The sender waits where it is too fast; no frame is dropped");
  command->add_option("--queue", options.queue, "Frames that may wait; of more the oldest one is dropped")
      ->check(whole_number_from(2, 1000))
      ->capture_default_str();
  command->add_flag("--map", options.with_map, "Recognize places and close loops; poses are those in the map");
  command->add_option("--save-map", options.saved_map, "Map to write at the end");
  CLI::Option* load = command->add_option("--load-map", options.loaded_map,
                                          "Saved map to begin with; poses are sound from where it is recognized on");
  command->add_flag("--localize", options.localize_only, "The loaded map is not changed")->needs(load);
  command->add_option("--trajectory", options.trajectory, "Trajectory to write at the end, TUM format");
  command
      ->add_option("--page", options.page,
                   "Port of 127.0.0.1 for a page that shows the trajectory and, with a map, the map as they grow")
      ->check(whole_number_from(0, 65535));
}

void add_calibration(CLI::App& app, CalibrationOptions& options) {
  CLI::App* command =
      app.add_subcommand("calibration", "Print what is understood of a calibration file, and convert it");
  command->footer(
      "Examples:\n"
      "  plumbline calibration camchain.yaml\n"
      "  plumbline calibration sensor.yaml --imu-calibration imu.yaml --to kalibr > camchain.yaml");
  command->add_option("file", options.file, "Calibration, of any format that is read")->required();
  command->add_option("--imu-calibration", options.imu_calibration,
                      "Noise of the IMU (Kalibr imu.yaml), instead of the calibration's");
  command->add_option("--to", options.to, "Format to write: kalibr or plain, under the description as comments");
}

void add_doctor(CLI::App& app, DoctorOptions& options) {
  CLI::App* command = app.add_subcommand("doctor", "Check a recording with its calibration, by all of its images");
  command->footer(
      "Examples:\n"
      "  plumbline doctor my_recording --calibration camchain.yaml\n"
      "  plumbline doctor my_recording --report doctor.html");
  command->add_option("dataset,--dataset", options.dataset, "Folder of the recording")->required();
  add_inputs(*command, options.inputs);
  command->add_option("--json", options.json, "All diagnoses to write, JSON");
  command->add_option("--report", options.report, "Page to write, HTML");
}

void add_evaluate(CLI::App& app, EvaluateOptions& options) {
  CLI::App* command =
      app.add_subcommand("evaluate", "Compare a trajectory with the truth (ATE and RPE as evo has them)");
  command->footer("Example:\n  plumbline evaluate --reference groundtruth.txt --estimate out.tum --align posyaw");
  command->add_option("--reference", options.reference, "True trajectory: TUM, EuRoC or KITTI format")->required();
  command->add_option("--estimate", options.estimates, "Estimated trajectory, or several")->required();
  command->add_option("--to-camera", options.to_camera,
                      "Calibration with T_body_camera: the reference is of the body, the estimate of its camera");
  command->add_option("--align", options.align, "se3, sim3, posyaw or none")->capture_default_str();
  command->add_option("--max-difference", options.max_difference_s, "Largest time between a pair of poses [s]")
      ->check(number_from(0, 1e9, "s"))
      ->capture_default_str();
  command->add_option("--rpe-delta", options.rpe_delta, "Step of the relative error")
      ->check(number_from(1e-6, 1e9))
      ->capture_default_str();
  command->add_option("--rpe-unit", options.rpe_unit, "s, frames or m")->capture_default_str();
  command->add_option("--plot", options.plot, "Picture of the trajectories to write, PNG or JPEG");
  command->add_option("--error-plot", options.error_plot, "Picture of the error over time to write, PNG or JPEG");
  command->add_flag("--json", options.json, "Print JSON instead of a table");
}

void add_map(CLI::App& app, SavedMapOptions& options) {
  CLI::App* command = app.add_subcommand("map", "Print what is in a saved map, and export it");
  command->add_option("file", options.file, "Map that `plumbline run --save-map` wrote")->required();
  command->add_option("--ply", options.ply, "Points to write, PLY");
  command->add_option("--colmap", options.colmap, "Folder for a COLMAP model as text: keyframes and points");
  command->add_option("--report", options.report, "Page to write, HTML");
}

/// As they come from the field; `plumbline doctor` finds them.
void add_simulated_faults(CLI::App& command, SimulateFaults& faults) {
  command
      .add_option("--noise-factor", faults.noise_factor, "White noise of the IMU by that which the calibration states")
      ->check(number_from(0.01, 100, ""));
  command.add_option("--gyro-range", faults.gyro_range, "The gyroscope is saturated there [rad/s]")
      ->check(number_from(0.1, 100, "rad/s"));
  command.add_option("--accel-range", faults.accel_range, "The accelerometer is saturated there [m/s^2]")
      ->check(number_from(5, 1000, "m/s^2"));
  command.add_option("--vibration", faults.vibration, "Vibration of the accelerometer: rms [m/s^2] and frequency [Hz]")
      ->check(number_from(0, 100, ""))
      ->expected(2);
  command.add_flag("--accel-sign", faults.accel_sign, "The sign of the accelerometer is reversed");
  command.add_option("--held-accel", faults.held_accel, "The accelerometer repeats each value in so many rows")
      ->check(whole_number_from(1, 20));
  command.add_option("--bursts", faults.bursts, "IMU samples come in bursts of so many, with stamps of arrival")
      ->check(whole_number_from(1, 100));
  command
      .add_option("--extrinsics-turn", faults.extrinsics_turn_deg,
                  "The stated camera is turned by this rotation vector about its axes [deg]")
      ->check(number_from(-180, 180, "degrees"))
      ->expected(3);
  command.add_option("--stated-depth-scale", faults.stated_depth_scale, "Raw units per meter as stated; true: 1000")
      ->check(number_from(1, 1e6, "units per meter"));
  command.add_option("--bonnet", faults.bonnet, "Lower part of the images that shows the vehicle")
      ->check(number_from(0, 0.6, ""));
}

void add_simulate(CLI::App& app, SimulateOptions& options) {
  CLI::App* command = app.add_subcommand("simulate", "Make a recording of a simulated scene, with exact truth");
  command->footer("Example:\n  plumbline simulate --scene room --duration 20 --out room");
  CLI::Option* scene =
      command->add_option("--scene", options.scene, "One of: " + CLI::detail::join(scene_names(), ", "))
          ->capture_default_str();
  command->add_option("--out", options.out, "Folder to make")->required();
  command->add_option("--seed", options.seed, "Of the surfaces, the motion and the noise")
      ->check(whole_number_from(0, 1e15))
      ->capture_default_str();
  CLI::Option* duration = command->add_option("--duration", options.duration_s, "Length [s]")
                              ->check(number_from(0.05, 3600, "s"))
                              ->capture_default_str();
  CLI::Option* laps =
      command->add_option("--laps", options.laps, "Length in laps of the scene, in the place of --duration")
          ->check(whole_number_from(1, 100))
          ->excludes(duration);
  CLI::Option* stop = command->add_option("--stop", options.stop_s, "Begin and end of a stop on the way [s]")
                          ->check(number_from(0, 3600, "s"))
                          ->expected(2);
  command->add_option("--late", options.late_s, "The stamps of the images come after the images by so much [s]")
      ->check(number_from(-0.5, 0.5, "s"))
      ->capture_default_str();
  command
      ->add_option("--readout", options.readout_s,
                   "The shutter rolls: from the first row of an image to the last one [s]; the middle one at the stamp")
      ->check(number_from(0, 0.05, "s"))
      ->capture_default_str();
  command->add_option("--drop", options.drop, "Part of the images that is missing, in gaps of up to 0.4 s")
      ->check(number_from(0, 0.7, ""))
      ->capture_default_str();
  command->add_option("--size", options.size, "Width and height of the images [px]")
      ->check(whole_number_from(160, 4096))
      ->expected(2);
  CLI::Option* imu = command->add_option("--imu", options.imu, "One of: " + CLI::detail::join(imu_names(), ", "))
                         ->capture_default_str();
  CLI::Option* layout =
      command->add_option("--layout", options.layout, "One of: " + CLI::detail::join(layout_names(), ", "))
          ->capture_default_str();
  add_simulated_faults(*command, options.faults);
  CLI::Option* real = command->add_option("--real-imu", options.real_imu,
                                          "Recording in the EuRoC layout: images of a hall along its true path, beside "
                                          "its IMU samples");
  for (CLI::Option* other : {scene, laps, stop, imu, layout}) real->excludes(other);
  for (const char* other : {"--noise-factor", "--stated-depth-scale"}) real->excludes(command->get_option(other));
  command->add_option("--calibration", options.calibration, "Of the camera, where the recording has none")->needs(real);
  command->add_option("--start", options.start_s, "Begin in that recording [s]")
      ->check(number_from(0, longest_s, "s"))
      ->needs(real);
}

void add_faults(CLI::App& app, FaultOptions& options) {
  CLI::App* command = app.add_subcommand("faults", "Runs whose images or IMU samples fail for some time");
  command->add_option("--config", options.configs, "Configurations")->required();
  command->add_option("--dataset", options.datasets, "Folders of recordings with truth")->required();
  add_inputs(*command, options.inputs);
  command->add_flag("--map", options.with_map, "With a map; poses are those in it");
  command->footer(
      "Example:\n  plumbline faults --config mono-imu/points/window --dataset MH_01_easy --fault black --for 1");
  command->add_option("--fault", options.kinds, "Of: " + CLI::detail::join(fault_names(), ", ") + "; all by default");
  command->add_option("--for", options.durations_s, "Durations of failing images [s]")
      ->check(number_from(0.001, longest_s, "s"))
      ->capture_default_str();
  command->add_option("--times", options.times, "Each fault at so many times")->check(whole_number_from(1, 1000));
  add_results(*command, options.results);
}

void add_starts(CLI::App& app, StartOptions& options) {
  CLI::App* command = app.add_subcommand("starts", "Initialization in runs that begin at many times of a recording");
  command->add_option("--config", options.configs, "Configurations")->required();
  command->add_option("--dataset", options.datasets, "Folders of recordings with truth")->required();
  add_inputs(*command, options.inputs);
  command->add_flag("--map", options.with_map, "With a map; poses are those in it");
  command->footer("Example:\n  plumbline starts --config mono-imu/points/window --dataset MH_01_easy --every 2");
  command->add_option("--every", options.every_s, "Time between the begins of two runs [s]")
      ->check(number_from(0.001, longest_s, "s"));
  command->add_option("--duration", options.duration_s, "Length of each run [s]")
      ->check(number_from(0.001, longest_s, "s"));
  add_results(*command, options.results);
}

void add_relocalizations(CLI::App& app, RelocalizationOptions& options) {
  CLI::App* command = app.add_subcommand(
      "relocalizations", "Runs that begin at many times of a recording's second half, in a map of its first half");
  command->add_option("--config", options.configs, "Configurations")->required();
  command->add_option("--dataset", options.datasets, "Folders of recordings with truth")->required();
  add_inputs(*command, options.inputs);
  command->footer("Example:\n  plumbline relocalizations --config mono-imu/points/window --dataset MH_01_easy");
  command->add_option("--every", options.every_s, "Time between the begins of two runs [s]; 0: at every frame")
      ->check(number_from(0, longest_s, "s"))
      ->capture_default_str();
  command->add_option("--duration", options.duration_s, "Length of each run [s]")
      ->check(number_from(0.001, longest_s, "s"))
      ->capture_default_str();
  add_results(*command, options.results);
}

/// A name that is empty is one that a script has lost.
void refuse_empty_values(CLI::App& app) {
  const CLI::Validator is_there([](const std::string& text) { return text.empty() ? "must not be empty" : ""; }, "");
  for (CLI::App* command : app.get_subcommands(nullptr))
    for (CLI::Option* option : command->get_options())
      if (option->get_items_expected_max() > 0) option->check(is_there);
}

void add_compare(CLI::App& app, CompareOptions& options) {
  CLI::App* command = app.add_subcommand("compare", "Run configurations on recordings, and compare them");
  command->footer(
      "Example:\n"
      "  plumbline compare --config 'mono-imu/*/window' --dataset MH_01_easy --json out.json --report out.html");
  command->add_option("--config", options.configs, "Configurations, or patterns such as 'rgbd/points*/window'");
  command->add_option("--dataset", options.datasets, "Folders or bags of recordings with truth");
  add_inputs(*command, options.inputs);
  command->add_flag("--map", options.with_map, "With a map; poses are those in it");
  command->add_option("--json", options.json, "All figures to write");
  command->add_option("--report", options.report, "Page to write, HTML");
  command->add_option("--markdown", options.markdown, "Table to write, Markdown");
  command->add_option("--repeat", options.repeats, "Runs of each, begun one frame apart")->check(CLI::PositiveNumber);
  command->add_option("--jobs", options.processes, "Runs side by side, instead of one for each core")
      ->check(CLI::PositiveNumber);
  command->add_option("--shard", options.shard, "I/N: part I of N of the runs, for --merge");
  command->add_option("--merge", options.merge, "Files of comparisons to put together");
  command->add_option("--start", options.start_s, "Begin this long after the first frame [s]")
      ->check(number_from(0, longest_s, "s"));
  command->add_option("--duration", options.duration_s, "Length of the part to run [s]")
      ->check(number_from(0.001, longest_s, "s"));
  command->add_option("--limit", options.limit_s, "Time after which a run has failed [s]")
      ->check(number_from(0.001, longest_s, "s"))
      ->capture_default_str();
}

/// What went wrong, in one line.
int fail(const std::string& text, int status = 1) {
  std::fprintf(stderr, "plumbline: %s\n", plumbline::io::printable(text).c_str());
  return status;
}

}  // namespace

int main(int argc, char* argv[]) {  // NOLINT(bugprone-exception-escape): two options of one name, a fault of this file
  CLI::App app("Visual odometry: estimate, compare, simulate", "plumbline");
  app.require_subcommand(1);
  app.set_version_flag("--version", "plumbline " PLUMBLINE_VERSION);
  ListOptions list_options;
  RunOptions run_options;
  LiveOptions live_options;
  EvaluateOptions evaluate_options;
  SavedMapOptions map_options;
  DoctorOptions doctor_options;
  CalibrationOptions calibration_options;
  SimulateOptions simulate_options;
  ConvertOptions convert_options;
  FaultOptions fault_options;
  StartOptions start_options;
  RelocalizationOptions relocalization_options;
  CompareOptions compare_options;
  TableOptions table_options;
  add_list(app, list_options);
  add_run(app, run_options);
  add_live(app, live_options);
  add_calibration(app, calibration_options);
  add_doctor(app, doctor_options);
  add_evaluate(app, evaluate_options);
  add_convert(app, convert_options);
  add_map(app, map_options);
  add_simulate(app, simulate_options);
  add_faults(app, fault_options);
  add_starts(app, start_options);
  add_relocalizations(app, relocalization_options);
  add_compare(app, compare_options);
  add_table(app, table_options);
  refuse_empty_values(app);
  const auto run_command = [&] {
    if (app.got_subcommand("list")) return list(list_options);
    if (app.got_subcommand("run")) return run_configuration(run_options);
    if (app.got_subcommand("live")) return run_live(live_options);
    if (app.got_subcommand("calibration")) return run_calibration(calibration_options);
    if (app.got_subcommand("doctor")) return run_doctor(doctor_options);
    if (app.got_subcommand("evaluate")) return run_evaluate(evaluate_options);
    if (app.got_subcommand("convert")) return run_convert(convert_options);
    if (app.got_subcommand("map")) return print_saved_map(map_options);
    if (app.got_subcommand("faults")) return run_faults(fault_options);
    if (app.got_subcommand("starts")) return run_starts(start_options);
    if (app.got_subcommand("relocalizations")) return run_relocalizations(relocalization_options);
    if (app.got_subcommand("compare")) return run_compare(compare_options);
    if (app.got_subcommand("table")) return run_table(table_options);
    return run_simulate(simulate_options);
  };
  try {
    std::vector<std::string> arguments = arguments_of(argc, argv);
    check_names(app, arguments);
    int status = 0;
    try {
      std::reverse(arguments.begin(), arguments.end());  // as the parser takes them
      app.parse(arguments);
      status = run_command();
    } catch (const CLI::Success& help) {
      status = app.exit(help);
    }
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) return fail("stdout: cannot be written (disk full?)");
    return status;
  } catch (const Interrupted& interruption) {
    return fail(interruption.what(), 130);
  } catch (const Misuse& misuse) {
    return fail(misuse.what(), misused);
  } catch (const CLI::ParseError& error) {
    return fail(wording_of(error), misused);
  } catch (const std::bad_alloc&) {
    return fail("out of memory");
  } catch (const std::exception& error) {
    return fail(error.what());
  }
}
