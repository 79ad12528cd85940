#pragma once
/// What a recording has and a run does not use.

#include <filesystem>
#include <string>
#include <vector>

#include "plumbline/io/recording.hpp"
#include "runner.hpp"

/// Why a recording's IMU samples or depth images cannot be used; empty where they can.
std::string why_no_imu(const plumbline::io::Recording& recording);
std::string why_no_depth(const plumbline::io::Recording& recording);

/// Throws std::runtime_error where the configuration needs what the recording lacks, with the reason.
void require_sensors(const Configuration& configuration, const plumbline::io::Recording& recording,
                     const std::filesystem::path& dataset);

/// The configuration's name, and the sensors of the recording for which it is the recommended one.
std::string why_recommended(const Configuration& configuration, const plumbline::io::Recording& recording);

/// One line for each sensor that no configuration can use, with the reason.
std::vector<std::string> unusable_sensors(const plumbline::io::Recording& recording);

/// One line for each sensor that the configuration does not use, with the reason and what to do about it.
std::vector<std::string> unused_sensors(const plumbline::io::Recording& recording, const Configuration& configuration);
