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

#include "compare.hpp"
#include "evaluate.hpp"
#include "faults.hpp"
#include "interrupt.hpp"
#include "memory.hpp"
#include "nearest.hpp"
#include "number_range.hpp"
#include "plumbline/io/printable.hpp"
#include "results.hpp"
#include "run.hpp"
#include "runner.hpp"
#include "simulate.hpp"
#include "starts.hpp"

namespace {

constexpr double longest_s = 1e7;  // four months

/// Throws at the first misspelled command or option, with the name that was probably meant.
void check_names(const CLI::App& app, std::span<char* const> arguments) {
  if (arguments.size() < 2 || std::string_view(arguments[1]).starts_with('-')) return;
  std::vector<std::string> known;
  const CLI::App* command = nullptr;
  for (const CLI::App* each : app.get_subcommands(nullptr)) {
    if (each->get_name() == arguments[1]) command = each;
    known.push_back(each->get_name());
  }
  if (command == nullptr) throw std::runtime_error(unknown_name("command", arguments[1], known));

  known.clear();
  for (const CLI::Option* option : command->get_options())
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  for (const std::string_view argument : arguments.subspan(2)) {
    const std::string name(argument.substr(0, argument.find('=')));
    if (name.starts_with("--") && std::find(known.begin(), known.end(), name) == known.end())
      throw std::runtime_error(unknown_name("option", name, known));
  }
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
  command->add_option("files", options.files, "Files of starts, faults, compare or list --memory")->required();
  command->add_option("--template", options.page, "Page with marks where tables go: <!-- table NAME -->");
  command->add_option("--command", options.command, "Command that made a comparison, for its table");
  add_results(*command, options.outputs);
}

void add_run(CLI::App& app, RunOptions& options) {
  CLI::App* command = app.add_subcommand("run", "Run one configuration on one recording");
  command->add_option("--config", options.config,
                      "Configuration, one of `plumbline list`; the one that fits the recording by default");
  command->add_option("--dataset", options.dataset, "Folder of the recording (EuRoC, TUM RGB-D, KITTI)")->required();
  command->add_option("--trajectory", options.files.trajectory, "Trajectory to write, TUM format")->required();
  command->add_option("--timing", options.files.timing, "Times, health and sigmas of each frame to write, CSV");
  command->add_option("--states", options.files.states,
                      "Pose, velocity, biases, covariance and readout time of each frame to write, CSV");
  command->add_flag("--all-poses", options.all_poses,
                    "Poses while lost, and of uncertain scale before initialization, too");
  command->add_option("--landmarks", options.files.landmarks, "Points of the final map to write, PLY");
  command->add_flag("--unchecked", options.is_unchecked, "Run although the recording looks wrong");
  command->add_option("--calibration", options.calibration, "Calibration instead of the recording's own");
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

void add_evaluate(CLI::App& app, EvaluateOptions& options) {
  CLI::App* command =
      app.add_subcommand("evaluate", "Compare a trajectory with the truth (ATE and RPE as evo has them)");
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

void add_simulate(CLI::App& app, SimulateOptions& options) {
  CLI::App* command = app.add_subcommand("simulate", "Make a recording of a simulated scene, with exact truth");
  command->add_option("--scene", options.scene, "One of: " + CLI::detail::join(scene_names(), ", "))
      ->capture_default_str();
  command->add_option("--out", options.out, "Folder to make")->required();
  command->add_option("--seed", options.seed, "Of the surfaces, the motion and the noise")
      ->check(whole_number_from(0, 1e15))
      ->capture_default_str();
  command->add_option("--duration", options.duration_s, "Length [s]")
      ->check(number_from(0.05, 3600, "s"))
      ->capture_default_str();
  command->add_option("--stop", options.stop_s, "Begin and end of a stop on the way [s]")
      ->check(number_from(0, 3600, "s"))
      ->expected(2);
  command->add_option("--late", options.late_s, "The stamps of the images come after the images by so much [s]")
      ->check(number_from(-0.2, 0.2, "s"))
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
  command->add_option("--imu", options.imu, "One of: " + CLI::detail::join(imu_names(), ", "))->capture_default_str();
  command->add_option("--layout", options.layout, "One of: " + CLI::detail::join(layout_names(), ", "))
      ->capture_default_str();
}

void add_faults(CLI::App& app, FaultOptions& options) {
  CLI::App* command = app.add_subcommand("faults", "Runs whose images or IMU samples fail for some time");
  command->add_option("--config", options.configs, "Configurations")->required();
  command->add_option("--dataset", options.datasets, "Folders of recordings with truth")->required();
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
  command->add_option("--every", options.every_s, "Time between the begins of two runs [s]")
      ->check(number_from(0.001, longest_s, "s"));
  command->add_option("--duration", options.duration_s, "Length of each run [s]")
      ->check(number_from(0.001, longest_s, "s"));
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
  command->add_option("--config", options.configs, "Configurations, or patterns such as 'rgbd/points*/window'");
  command->add_option("--dataset", options.datasets, "Folders of recordings with truth");
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

int main(int argc, char* argv[]) {
  CLI::App app("Visual odometry: estimate, compare, simulate", "plumbline");
  app.require_subcommand(1);
  app.set_version_flag("--version", "plumbline " PLUMBLINE_VERSION);
  ListOptions list_options;
  RunOptions run_options;
  EvaluateOptions evaluate_options;
  SimulateOptions simulate_options;
  FaultOptions fault_options;
  StartOptions start_options;
  CompareOptions compare_options;
  TableOptions table_options;
  add_list(app, list_options);
  add_run(app, run_options);
  add_evaluate(app, evaluate_options);
  add_simulate(app, simulate_options);
  add_faults(app, fault_options);
  add_starts(app, start_options);
  add_compare(app, compare_options);
  add_table(app, table_options);
  refuse_empty_values(app);
  const auto run_command = [&] {
    if (app.got_subcommand("list")) return list(list_options);
    if (app.got_subcommand("run")) return run_configuration(run_options);
    if (app.got_subcommand("evaluate")) return run_evaluate(evaluate_options);
    if (app.got_subcommand("faults")) return run_faults(fault_options);
    if (app.got_subcommand("starts")) return run_starts(start_options);
    if (app.got_subcommand("compare")) return run_compare(compare_options);
    if (app.got_subcommand("table")) return run_table(table_options);
    return run_simulate(simulate_options);
  };
  try {
    check_names(app, {argv, static_cast<std::size_t>(argc)});
    int status = 0;
    try {
      app.parse(argc, argv);
      status = run_command();
    } catch (const CLI::Success& help) {
      status = app.exit(help);
    }
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) return fail("stdout: cannot be written (disk full?)");
    return status;
  } catch (const Interrupted& interruption) {
    return fail(interruption.what(), 130);
  } catch (const std::bad_alloc&) {
    return fail("out of memory");
  } catch (const std::exception& error) {
    return fail(error.what());
  }
}
