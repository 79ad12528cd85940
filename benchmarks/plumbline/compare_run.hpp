#pragma once
/// One run of a comparison, evaluated with the ground truth.

#include <nlohmann/json.hpp>

#include "compare_plan.hpp"

/// Of the whole trajectory with the truth: with the scale for a camera alone, position and heading with an IMU.
const char* alignment_of(const Needs& needs);

/// A run as docs/compare.schema.json has it, before anything is known of it.
nlohmann::json json_of(const CompareJob& job);

struct CompareRun {
  nlohmann::json json;    ///< as docs/compare.schema.json has it
  std::size_t bytes = 0;  ///< of the estimator
};

/// Throws std::runtime_error where not even a run came about.
CompareRun run_compared(const CompareJob& job);
