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
  const std::string &model = calibration.model, &distortion = calibration.distortion;
  const auto number = [](const std::vector<double>& values, std::size_t i) {
    return i < values.size() ? static_cast<S>(values[i]) : S(0);
  };
  const auto v = [&](std::size_t i) { return number(calibration.intrinsics, i); };
  const auto k = [&](std::size_t i) { return number(calibration.distortion_coefficients, i); };
  const std::size_t expected = model == "pinhole" ? 4 : model == "omni" ? 5 : 6;
  if (calibration.intrinsics.size() != expected || calibration.distortion_coefficients.size() > 8)
    throw std::invalid_argument("a camera calibration with the wrong number of parameters");

  if (model == "double_sphere") return DoubleSphere<S>(v(0), v(1), v(2), v(3), v(4), v(5));
  if (model == "eucm") return Eucm<S>(v(0), v(1), v(2), v(3), v(4), v(5));
  const RadTan<S> radtan(k(0), k(1), k(2), k(3), k(4));
  if (model == "omni") {
    if (distortion == "none") return Omni<S>{v(0), v(1), v(2), v(3), v(4)};
    if (distortion == "radtan") return Omni<S>{v(0), v(1), v(2), v(3), v(4), radtan};
  }
  if (model == "pinhole") {
    if (distortion == "none") return Pinhole<S>{v(0), v(1), v(2), v(3)};
    if (distortion == "radtan") return Pinhole<S, RadTan>{v(0), v(1), v(2), v(3), radtan};
    if (distortion == "rational")
      return Pinhole<S, Rational>{v(0), v(1), v(2), v(3), Rational<S>(k(0), k(1), k(2), k(3), k(4), k(5), k(6), k(7))};
    if (distortion == "fov") return Pinhole<S, Fov>{v(0), v(1), v(2), v(3), Fov<S>(k(0))};
    if (distortion == "equidistant") return Equidistant<S>(v(0), v(1), v(2), v(3), k(0), k(1), k(2), k(3));
  }
  throw std::invalid_argument("no camera model " + model + " with distortion " + distortion);
}

}  // namespace plumbline::io
