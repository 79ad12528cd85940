#include "evaluate.hpp"

#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "plot.hpp"
#include "plumbline/io/trajectory.hpp"
#include "plumbline/io/trajectory_evaluation.hpp"

namespace io = plumbline::io;

namespace {

io::EvaluationSettings settings_of(const EvaluateOptions& options) {
  const std::optional<io::Alignment> alignment = io::alignment_named(options.align);
  if (!alignment) throw std::runtime_error("--align is none, se3, sim3 or posyaw, not " + options.align);
  const std::optional<io::DeltaUnit> unit = io::delta_unit_named(options.rpe_unit);
  if (!unit) throw std::runtime_error("the unit of the relative error is s, frames or m, not " + options.rpe_unit);
  if (!(options.rpe_delta > 0) ||
      (*unit == io::DeltaUnit::frames && options.rpe_delta != std::floor(options.rpe_delta)))
    throw std::runtime_error("the step of the relative error must be positive, and whole for frames");
  if (!(options.max_difference_s >= 0)) throw std::runtime_error("the largest time difference must not be negative");
  return {*alignment, options.max_difference_s, options.rpe_delta, *unit};
}

nlohmann::ordered_json json_of(const io::Statistics& s) {
  if (s.count == 0) return nullptr;
  return {{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median}, {"std", s.std},
          {"min", s.min},   {"max", s.max},   {"count", s.count}};
}

void print_json(const EvaluateOptions& options, const io::Evaluation& result) {
  nlohmann::ordered_json out;
  out["reference"] = options.reference.string();
  out["estimate"] = options.estimate.string();
  out["alignment"] = options.align;
  out["pairs"] = result.pairs;
  out["coverage"] = result.coverage;
  out["path_length_m"] = result.path_length_m;
  out["scale"] = result.scale;  // NaN becomes null
  out["ape"] = {{"translation_m", json_of(result.ape.translation)}, {"rotation_deg", json_of(result.ape.rotation_deg)}};
  out["rpe"] = {{"delta", options.rpe_delta},
                {"unit", options.rpe_unit},
                {"translation_m", json_of(result.rpe.translation)},
                {"rotation_deg", json_of(result.rpe.rotation_deg)}};
  std::printf("%s\n", out.dump(2).c_str());
}

void print_row(const char* name, const io::Statistics& s) {
  if (s.count == 0) {
    std::printf("%-24s %10s %10s %10s %10s %10s %10s %7d\n", name, "-", "-", "-", "-", "-", "-", 0);
  } else {
    std::printf("%-24s %10.6f %10.6f %10.6f %10.6f %10.6f %10.6f %7zu\n", name, s.rmse, s.mean, s.median, s.std, s.min,
                s.max, s.count);
  }
}

void print_table(const EvaluateOptions& options, const io::Evaluation& result) {
  std::printf("reference  %s\nestimate   %s\n", options.reference.c_str(), options.estimate.c_str());
  std::printf("alignment %s, %zu pairs, coverage %.1f %%, path %.3f m, scale (sim3) %.6f\n\n", options.align.c_str(),
              result.pairs, 100 * result.coverage, result.path_length_m, result.scale);
  std::printf("%-24s %10s %10s %10s %10s %10s %10s %7s\n", "", "rmse", "mean", "median", "std", "min", "max", "count");
  print_row("APE translation [m]", result.ape.translation);
  print_row("APE rotation [deg]", result.ape.rotation_deg);
  char name[64];
  std::snprintf(name, sizeof name, "RPE %g %s [m]", options.rpe_delta, options.rpe_unit.c_str());
  print_row(name, result.rpe.translation);
  std::snprintf(name, sizeof name, "RPE %g %s [deg]", options.rpe_delta, options.rpe_unit.c_str());
  print_row(name, result.rpe.rotation_deg);
}

}  // namespace

int run_evaluate(const EvaluateOptions& options) {
  const io::EvaluationSettings settings = settings_of(options);
  const io::Trajectory reference = io::read_trajectory(options.reference);
  const io::Evaluation result = io::evaluate_trajectory(reference, io::read_trajectory(options.estimate), settings);
  if (options.json) {
    print_json(options, result);
  } else {
    print_table(options, result);
  }
  if (!options.plot.empty()) {
    char title[128];
    std::snprintf(title, sizeof title, "ATE %.4f m rmse (%s), %zu pairs, path %.1f m", result.ape.translation.rmse,
                  options.align.c_str(), result.pairs, result.path_length_m);
    draw_trajectories(options.plot, reference, result.aligned, title);
  }
  return 0;
}
