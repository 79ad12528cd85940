#include "trajectory.hpp"

#include <cmath>

namespace pl = plumbline;
namespace py = pybind11;

py::array_t<std::int64_t> PythonTrajectory::t_ns() const {
  py::array_t<std::int64_t> out(static_cast<py::ssize_t>(poses.size()));
  std::int64_t* to = out.mutable_data();
  for (const pl::io::StampedPose& pose : poses) *to++ = pose.t_ns;
  return out;
}

py::array_t<double> PythonTrajectory::position() const {
  py::array_t<double> out({static_cast<py::ssize_t>(poses.size()), py::ssize_t{3}});
  double* to = out.mutable_data();
  for (const pl::io::StampedPose& pose : poses)
    for (int k = 0; k < 3; ++k) *to++ = pose.T_world_body.p()[k];
  return out;
}

py::array_t<double> PythonTrajectory::quaternion() const {
  py::array_t<double> out({static_cast<py::ssize_t>(poses.size()), py::ssize_t{4}});
  double* to = out.mutable_data();
  for (const pl::io::StampedPose& pose : poses)
    for (int k = 0; k < 4; ++k) *to++ = pose.T_world_body.rotation().quaternion().coeffs()[k];
  return out;
}

PythonTrajectory trajectory_of(const py::object& t_ns, const py::object& position, const py::object& quaternion) {
  const py::array_t<std::int64_t> times = times_of(t_ns);
  const py::ssize_t n = times.size();
  const py::array_t<double> p = rows_of(position, "position", n, 3), q = rows_of(quaternion, "quaternion", n, 4);
  const std::int64_t* t = times.data();
  PythonTrajectory out;
  for (py::ssize_t i = 0; i < n; ++i) {
    const double *at = p.data() + 3 * i, *x = q.data() + 4 * i;
    const Eigen::Quaterniond rotation(x[3], x[0], x[1], x[2]);
    const std::string row = "row " + std::to_string(i) + ": ";
    if (!(std::abs(rotation.norm() - 1) < 0.05)) throw py::value_error(row + "the quaternion is not of unit length");
    if (!std::isfinite(at[0] + at[1] + at[2])) throw py::value_error(row + "the position is not finite");
    if (i > 0 && t[i] <= t[i - 1]) throw py::value_error(row + "the time stamp is not after that of the row above");
    out.poses.push_back({t[i], pl::SE3<double>(pl::SO3<double>(rotation), pl::Vec<double, 3>(at[0], at[1], at[2]))});
  }
  return out;
}
