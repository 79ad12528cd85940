#pragma once
/// The camera model a calibration names.

#include <concepts>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "plumbline/camera/any_camera.hpp"
#include "plumbline/io/calibration_data.hpp"

namespace plumbline::io {

/// For a calibration `read_calibration` has checked; one made by hand may throw std::invalid_argument.
template <std::floating_point S>
AnyCamera<S> make_camera(const CameraCalibration& calibration) {
  const bool is_double_sphere = calibration.model == "double_sphere";
  const auto number = [](const std::vector<double>& values, std::size_t i) {
    return i < values.size() ? static_cast<S>(values[i]) : S(0);
  };
  const auto v = [&](std::size_t i) { return number(calibration.intrinsics, i); };
  const auto k = [&](std::size_t i) { return number(calibration.distortion_coefficients, i); };
  if (calibration.intrinsics.size() != (is_double_sphere ? 6 : 4) || calibration.distortion_coefficients.size() > 5)
    throw std::invalid_argument("a camera calibration with the wrong number of parameters");

  if (is_double_sphere) return DoubleSphere<S>(v(0), v(1), v(2), v(3), v(4), v(5));
  if (calibration.model == "pinhole") {
    if (calibration.distortion == "none") return Pinhole<S>{v(0), v(1), v(2), v(3)};
    if (calibration.distortion == "radtan")
      return Pinhole<S, RadTan>{v(0), v(1), v(2), v(3), RadTan<S>(k(0), k(1), k(2), k(3), k(4))};
    if (calibration.distortion == "equidistant") return Equidistant<S>(v(0), v(1), v(2), v(3), k(0), k(1), k(2), k(3));
  }
  throw std::invalid_argument("no camera model " + calibration.model + " with distortion " + calibration.distortion);
}

}  // namespace plumbline::io
