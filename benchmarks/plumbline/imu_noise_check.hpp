#pragma once
/// The checks of `plumbline doctor` of the noise of an IMU: densities at rest against those that are stated, vibration
/// in motion, saturation.

#include <vector>

#include "doctor.hpp"
#include "imu_noise_figures.hpp"

std::vector<Diagnosis> check_imu_noise(const plumbline::io::Recording& recording, const ImuNoiseFigures& figures);
std::vector<Diagnosis> check_saturation(const plumbline::io::Recording& recording);
