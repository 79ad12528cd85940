#include "evaluation_figures.hpp"

#include <cmath>
#include <optional>

#include "misuse.hpp"

namespace io = plumbline::io;

io::EvaluationSettings evaluation_settings(const std::string& align, double max_difference_s, double rpe_delta,
                                           const std::string& rpe_unit) {
  const std::optional<io::Alignment> alignment = io::alignment_named(align);
  if (!alignment) throw Misuse("the alignment is none, se3, sim3 or posyaw, not " + align);
  const std::optional<io::DeltaUnit> unit = io::delta_unit_named(rpe_unit);
  if (!unit) throw Misuse("the unit of the relative error is s, frames or m, not " + rpe_unit);
  if (!(rpe_delta > 0) || (*unit == io::DeltaUnit::frames && rpe_delta != std::floor(rpe_delta)))
    throw Misuse("the step of the relative error must be positive, and whole for frames");
  if (!(max_difference_s >= 0)) throw Misuse("the largest time difference must not be negative");
  return {*alignment, max_difference_s, rpe_delta, *unit};
}

static nlohmann::ordered_json statistics_of(const io::Statistics& s) {
  if (s.count == 0) return nullptr;
  return {{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median}, {"std", s.std},
          {"min", s.min},   {"max", s.max},   {"count", s.count}};
}

nlohmann::ordered_json json_of(const io::Evaluation& result, double rpe_delta, const std::string& rpe_unit) {
  nlohmann::ordered_json out;
  out["poses"] = result.poses;
  out["pairs"] = result.pairs;
  out["unpaired"] = result.poses - result.pairs;
  out["coverage"] = result.coverage;
  out["path_length_m"] = result.path_length_m;
  out["scale"] = result.scale;
  out["ape"] = {{"translation_m", statistics_of(result.ape.translation)},
                {"rotation_deg", statistics_of(result.ape.rotation_deg)}};
  out["rpe"] = {{"delta", rpe_delta},
                {"unit", rpe_unit},
                {"translation_m", statistics_of(result.rpe.translation)},
                {"rotation_deg", statistics_of(result.rpe.rotation_deg)}};
  return out;
}
