#pragma once
/// The comparison of two trajectories as names and figures: what is asked for, and the result as JSON.

#include <string>

#include <nlohmann/json.hpp>

#include "plumbline/io/trajectory_evaluation.hpp"

/// `align` is none, se3, sim3 or posyaw, `rpe_unit` s, frames or m. Throws Misuse.
plumbline::io::EvaluationSettings evaluation_settings(const std::string& align, double max_difference_s,
                                                      double rpe_delta, const std::string& rpe_unit);

/// Numbers that are not finite become null, and so do statistics of nothing.
nlohmann::ordered_json json_of(const plumbline::io::Evaluation& result, double rpe_delta, const std::string& rpe_unit);
