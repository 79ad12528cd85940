#pragma once
/// plumbline.Trajectory: poses with time stamps, as arrays.

#include <pybind11/pybind11.h>

#include "arrays.hpp"
#include "plumbline/io/trajectory.hpp"

struct PythonTrajectory {
  plumbline::io::Trajectory poses;

  pybind11::array_t<std::int64_t> t_ns() const;
  pybind11::array_t<double> position() const;    ///< rows x y z [m]
  pybind11::array_t<double> quaternion() const;  ///< rows x y z w
};

/// Throws ValueError where the shapes do not fit, a quaternion is not of unit length, or times are not increasing.
PythonTrajectory trajectory_of(const pybind11::object& t_ns, const pybind11::object& position,
                               const pybind11::object& quaternion);
