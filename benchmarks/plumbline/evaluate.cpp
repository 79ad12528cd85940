#include "evaluate.hpp"

#include <cstdio>
#include <optional>
#include <set>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "evaluation_figures.hpp"
#include "format.hpp"
#include "output_check.hpp"
#include "plot.hpp"
#include "plumbline/io/calibration.hpp"
#include "plumbline/io/printable.hpp"
#include "plumbline/io/trajectory.hpp"
#include "plumbline/io/trajectory_evaluation.hpp"

namespace io = plumbline::io;

namespace {

/// An estimate and how it compares.
struct Judged {
  std::filesystem::path file;
  io::Evaluation result;

  std::size_t unpaired() const { return result.poses - result.pairs; }
};

nlohmann::ordered_json json_of(const EvaluateOptions& options, const Judged& judged) {
  nlohmann::ordered_json out;
  out["reference"] = io::printable(options.reference.string());
  out["estimate"] = io::printable(judged.file.string());
  out["alignment"] = options.align;
  out.update(::json_of(judged.result, options.rpe_delta, options.rpe_unit));
  return out;
}

/// One object for one estimate, a list for several.
void print_json(const EvaluateOptions& options, const std::vector<Judged>& all) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const Judged& judged : all) out.push_back(json_of(options, judged));
  std::printf("%s\n", (all.size() == 1 ? out[0] : out).dump(2).c_str());
}

void print_row(const char* name, const io::Statistics& s) {
  if (s.count == 0) {
    std::printf("%-24s %10s %10s %10s %10s %10s %10s %7d\n", name, "-", "-", "-", "-", "-", "-", 0);
  } else {
    std::printf("%-24s %10.6f %10.6f %10.6f %10.6f %10.6f %10.6f %7zu\n", name, s.rmse, s.mean, s.median, s.std, s.min,
                s.max, s.count);
  }
}

void print_table(const EvaluateOptions& options, const Judged& judged) {
  const io::Evaluation& result = judged.result;
  std::printf("reference  %s\nestimate   %s\n", io::printable(options.reference.string()).c_str(),
              io::printable(judged.file.string()).c_str());
  std::printf(
      "alignment %s, %zu pairs, %zu of %zu poses without partner, coverage %.1f %%, path %.3f m, scale (sim3) "
      "%.6f\n\n",
      options.align.c_str(), result.pairs, judged.unpaired(), result.poses, 100 * result.coverage, result.path_length_m,
      result.scale);
  std::printf("%-24s %10s %10s %10s %10s %10s %10s %7s\n", "", "rmse", "mean", "median", "std", "min", "max", "count");
  print_row("APE translation [m]", result.ape.translation);
  print_row("APE rotation [deg]", result.ape.rotation_deg);
  char name[64];
  std::snprintf(name, sizeof name, "RPE %g %s [m]", options.rpe_delta, options.rpe_unit.c_str());
  print_row(name, result.rpe.translation);
  std::snprintf(name, sizeof name, "RPE %g %s [deg]", options.rpe_delta, options.rpe_unit.c_str());
  print_row(name, result.rpe.rotation_deg);
}

/// Several estimates side by side, a row each.
void print_rows(const EvaluateOptions& options, const std::vector<Judged>& all) {
  std::printf("reference  %s\nalignment %s; RPE over %g %s; root mean squares\n\n",
              io::printable(options.reference.string()).c_str(), options.align.c_str(), options.rpe_delta,
              options.rpe_unit.c_str());
  std::printf("%9s %9s %9s %9s %9s %9s %7s %9s %9s  %s\n", "ATE [m]", "max [m]", "[deg]", "RPE [m]", "[deg]", "scale",
              "pairs", "unpaired", "coverage", "estimate");
  for (const Judged& judged : all) {
    const io::Evaluation& result = judged.result;
    std::printf("%9.4f %9.4f %9.3f %9.4f %9.3f %9.4f %7zu %9zu %7.1f %%  %s\n", result.ape.translation.rmse,
                result.ape.translation.max, result.ape.rotation_deg.rmse, result.rpe.translation.rmse,
                result.rpe.rotation_deg.rmse, result.scale, result.pairs, judged.unpaired(), 100 * result.coverage,
                io::printable(judged.file.string()).c_str());
  }
}

Judged judge(const std::filesystem::path& file, const io::Trajectory& reference,
             const io::EvaluationSettings& settings) {
  const io::Trajectory estimate = io::read_trajectory(file);
  try {
    return {file, io::evaluate_trajectory(reference, estimate, settings)};
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

io::Trajectory read_reference(const EvaluateOptions& options) {
  io::Trajectory reference = io::read_trajectory(options.reference);
  if (options.to_camera.empty()) return reference;
  const std::optional<plumbline::SE3<double>> T_body_camera = io::read_calibration(options.to_camera).T_body_camera;
  if (!T_body_camera) throw std::runtime_error(options.to_camera.string() + ": has no T_body_camera");
  return io::moved_to(reference, *T_body_camera);
}

void check_pictures(const EvaluateOptions& options) {
  std::vector<std::filesystem::path> inputs = options.estimates;
  inputs.push_back(options.reference);
  if (!options.to_camera.empty()) inputs.push_back(options.to_camera);
  std::vector<NamedOutput> outputs;
  if (!options.plot.empty()) outputs.push_back({"--plot", options.plot});
  if (!options.error_plot.empty()) outputs.push_back({"--error-plot", options.error_plot});
  for (const NamedOutput& output : outputs) require_picture_name(output.file);
  check_outputs(outputs, inputs);
}

void draw(const EvaluateOptions& options, const io::Trajectory& reference, const std::vector<Judged>& all) {
  std::vector<NamedTrajectory> trajectories;
  std::vector<ErrorCurve> curves;
  std::set<std::filesystem::path> stems;
  for (const Judged& judged : all) stems.insert(judged.file.stem());
  const bool are_distinct = stems.size() == all.size();
  for (const Judged& judged : all) {
    const std::string name = io::printable(are_distinct ? judged.file.stem().string() : judged.file.string());
    trajectories.push_back({all.size() == 1 ? "estimate" : name, judged.result.aligned});
    curves.push_back({all.size() == 1 ? "estimate" : name, judged.result.errors});
  }
  const io::Evaluation& first = all.front().result;
  const std::string title = all.size() == 1
                                ? format("ATE %.4f m rmse (%s), %zu pairs, path %.1f m", first.ape.translation.rmse,
                                         options.align.c_str(), first.pairs, first.path_length_m)
                                : format("%zu estimates, aligned by %s", all.size(), options.align.c_str());
  if (!options.plot.empty()) draw_trajectories(options.plot, reference, trajectories, title);
  if (!options.error_plot.empty()) draw_errors(options.error_plot, curves, title);
}

}  // namespace

int run_evaluate(const EvaluateOptions& options) {
  const io::EvaluationSettings settings =
      evaluation_settings(options.align, options.max_difference_s, options.rpe_delta, options.rpe_unit);
  check_pictures(options);
  const io::Trajectory reference = read_reference(options);
  std::vector<Judged> all;
  for (const std::filesystem::path& file : options.estimates) all.push_back(judge(file, reference, settings));
  draw(options, reference, all);
  if (options.json) {
    print_json(options, all);
  } else if (all.size() == 1) {
    print_table(options, all.front());
  } else {
    print_rows(options, all);
  }
  return 0;
}
