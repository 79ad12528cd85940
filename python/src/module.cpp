// The Python module plumbline._plumbline; plumbline/__init__.py has its names, plumbline/__init__.pyi their types.
#include <cmath>
#include <exception>
#include <filesystem>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "arrays.hpp"
#include "estimator.hpp"
#include "evaluation_figures.hpp"
#include "misuse.hpp"
#include "plumbline/io/printable.hpp"
#include "run.hpp"
#include "trajectory.hpp"

namespace fs = std::filesystem;
namespace io = plumbline::io;
namespace pl = plumbline;
namespace py = pybind11;
using namespace py::literals;

namespace {

/// What the library throws becomes plumbline.Error, Refused or ValueError, with the same text.
void add_errors(py::module_& m) {
  static PyObject* error = PyErr_NewException("plumbline.Error", PyExc_RuntimeError, nullptr);
  static PyObject* refused = PyErr_NewException("plumbline.Refused", error, nullptr);
  m.attr("Error") = py::handle(error);
  m.attr("Refused") = py::handle(refused);
  py::register_exception_translator([](std::exception_ptr thrown) {
    if (!thrown) return;
    const auto raise = [](PyObject* type, const std::exception& e) {
      PyErr_SetString(type, io::printable(e.what()).c_str());
    };
    try {
      std::rethrow_exception(thrown);
    } catch (const py::builtin_exception&) {
      throw;  // pybind11 has these
    } catch (const Refused& e) {
      raise(refused, e);
    } catch (const Misuse& e) {
      raise(PyExc_ValueError, e);
    } catch (const std::runtime_error& e) {
      raise(error, e);
    }
  });
}

/// 4 x 4.
py::array_t<double> matrix_of(const pl::SE3<double>& T) {
  pl::Mat<double, 4, 4> out = pl::Mat<double, 4, 4>::Identity();
  out.topLeftCorner<3, 3>() = T.R();
  out.topRightCorner<3, 1>() = T.p();
  return array_of(out);
}

void add_state(py::module_& m) {
  const auto estimate = [](const FrameOutput& out) -> const pl::Estimate<double>& { return out.estimate; };
  py::class_<FrameOutput>(m, "State")
      .def_property_readonly("t_ns", &FrameOutput::pose_ns)
      .def_property_readonly("health", [](const FrameOutput& out) { return name_of(out.health()); })
      .def_property_readonly("reason", [=](const FrameOutput& out) { return name_of(estimate(out).health.reason); })
      .def_property_readonly("has_pose", &FrameOutput::has_pose)
      .def_property_readonly("is_sound", [](const FrameOutput& out) { return out.has_sound_pose() && out.is_in_map; })
      .def_property_readonly("position", [](const FrameOutput& out) { return array_of(out.T_map_body().p()); })
      .def_property_readonly(
          "quaternion",
          [](const FrameOutput& out) { return array_of(out.T_map_body().rotation().quaternion().coeffs()); })
      .def_property_readonly("T_map_body", [](const FrameOutput& out) { return matrix_of(out.T_map_body()); })
      .def_property_readonly("T_world_body",
                             [=](const FrameOutput& out) { return matrix_of(estimate(out).T_world_body); })
      .def_property_readonly("covariance", [=](const FrameOutput& out) { return array_of(estimate(out).covariance); })
      .def_property_readonly("velocity", [=](const FrameOutput& out) { return array_of(estimate(out).v_world_body); })
      .def_property_readonly("bias_gyro", [=](const FrameOutput& out) { return array_of(estimate(out).bias_gyro); })
      .def_property_readonly("bias_accel", [=](const FrameOutput& out) { return array_of(estimate(out).bias_accel); })
      .def_property_readonly("tracked", [=](const FrameOutput& out) { return estimate(out).tracked; })
      .def_property_readonly("is_keyframe", [=](const FrameOutput& out) { return estimate(out).keyframe; })
      .def_property_readonly("resets", [=](const FrameOutput& out) { return estimate(out).resets; })
      .def_property_readonly("total_ms", [](const FrameOutput& out) { return 1e3 * out.timing.total; })
      .def("__repr__", [=](const FrameOutput& out) {
        return "State(t_ns=" + std::to_string(out.pose_ns()) + ", health='" + name_of(out.health()) + "', reason='" +
               name_of(estimate(out).health.reason) + "')";
      });
}

void add_estimator(py::module_& m) {
  py::class_<PythonEstimator>(m, "Estimator")
      .def(py::init([](const std::string& config, const fs::path& calibration,
                       const std::optional<fs::path>& imu_calibration, double depth_scale, bool map) {
             return std::make_unique<PythonEstimator>(config, calibration,
                                                      PythonEstimator::Options{imu_calibration, depth_scale, map});
           }),
           "config"_a, "calibration"_a, py::kw_only(), "imu_calibration"_a = py::none(), "depth_scale"_a = 0.0,
           "map"_a = false)
      .def("add_imu", &PythonEstimator::add_imu, "t_ns"_a, "gyro"_a, "accel"_a)
      .def("add_frame", &PythonEstimator::add_frame, "t_ns"_a, "gray"_a, "depth"_a = py::none())
      .def_property_readonly("state", &PythonEstimator::state)
      .def_property_readonly("health", [](const PythonEstimator& self) { return name_of(self.health()); })
      .def_property_readonly("covariance",
                             [](const PythonEstimator& self) -> std::optional<py::array_t<double>> {
                               const std::optional<FrameOutput> state = self.state();
                               if (!state) return std::nullopt;
                               return array_of(state->estimate.covariance);
                             })
      .def_property_readonly("landmarks", &PythonEstimator::landmarks)
      .def_property_readonly("time_offset_s", &PythonEstimator::time_offset_s)
      .def_property_readonly("config", &PythonEstimator::config);
}

void add_trajectory(py::module_& m) {
  py::class_<PythonTrajectory>(m, "Trajectory")
      .def(py::init(&trajectory_of), "t_ns"_a, "position"_a, "quaternion"_a)
      .def_static(
          "read", [](const fs::path& file) { return PythonTrajectory{io::read_trajectory(file)}; }, "file"_a)
      .def(
          "write",
          [](const PythonTrajectory& self, const fs::path& file) {
            io::TrajectoryWriter writer(file);
            for (const io::StampedPose& pose : self.poses) writer.add(pose);
            writer.complete();
            writer.commit();
          },
          "file"_a)
      .def("__len__", [](const PythonTrajectory& self) { return self.poses.size(); })
      .def_property_readonly("t_ns", &PythonTrajectory::t_ns)
      .def_property_readonly("position", &PythonTrajectory::position)
      .def_property_readonly("quaternion", &PythonTrajectory::quaternion);
}

void add_run(py::module_& m) {
  py::class_<PythonRun>(m, "Run")
      .def_readonly("config", &PythonRun::config)
      .def_property_readonly("trajectory", [](const PythonRun& run) { return PythonTrajectory{run.trajectory}; })
      .def_property_readonly(
          "landmarks",
          [](const PythonRun& run) {
            py::array_t<double> out({static_cast<py::ssize_t>(run.landmarks.size()), py::ssize_t{3}});
            double* to = out.mutable_data();
            for (const auto& p : run.landmarks)
              for (int k = 0; k < 3; ++k) *to++ = p[k];
            return out;
          })
      .def_readonly("summary", &PythonRun::summary)
      .def_readonly("notes", &PythonRun::notes);
  m.def(
      "run",
      [](const fs::path& dataset, const std::optional<std::string>& config, bool map,
         const std::optional<fs::path>& calibration, const std::optional<fs::path>& imu_calibration, double depth_scale,
         std::optional<double> time_offset_s, bool all_poses, bool unchecked, double start_s, double duration_s) {
        PythonRunOptions options;
        options.config = config.value_or("");
        options.with_map = map;
        options.all_poses = all_poses;
        options.is_unchecked = unchecked;
        options.start_s = start_s;
        options.duration_s = duration_s;
        options.inputs.calibration = calibration;
        options.inputs.imu_calibration = imu_calibration;
        options.inputs.depth_scale = depth_scale;
        options.inputs.time_offset_s = time_offset_s;
        return run_recording(dataset, options);
      },
      "dataset"_a, "config"_a = py::none(), "map"_a = false, py::kw_only(), "calibration"_a = py::none(),
      "imu_calibration"_a = py::none(), "depth_scale"_a = 0.0, "time_offset_s"_a = py::none(), "all_poses"_a = false,
      "unchecked"_a = false, "start_s"_a = 0.0, "duration_s"_a = std::numeric_limits<double>::infinity());
}

using TrajectoryOrFile = std::variant<PythonTrajectory, fs::path>;

io::Trajectory poses_of(const TrajectoryOrFile& given) {
  if (const auto* file = std::get_if<fs::path>(&given)) return io::read_trajectory(*file);
  const io::Trajectory& poses = std::get<PythonTrajectory>(given).poses;
  if (poses.empty()) throw std::runtime_error("a trajectory has no poses");
  return poses;
}

void add_evaluate(py::module_& m) {
  m.def(
      "evaluate",
      [](const TrajectoryOrFile& reference, const TrajectoryOrFile& estimate, const std::string& align,
         double max_difference_s, double rpe_delta, const std::string& rpe_unit) {
        const io::EvaluationSettings settings = evaluation_settings(align, max_difference_s, rpe_delta, rpe_unit);
        std::string figures;
        {
          const py::gil_scoped_release release;
          const io::Evaluation result = io::evaluate_trajectory(poses_of(reference), poses_of(estimate), settings);
          figures = json_of(result, rpe_delta, rpe_unit).dump();
        }
        return py::module_::import("json").attr("loads")(figures);
      },
      "reference"_a, "estimate"_a, py::kw_only(), "align"_a = "se3", "max_difference_s"_a = 0.02, "rpe_delta"_a = 1.0,
      "rpe_unit"_a = "s");
}

}  // namespace

PYBIND11_MODULE(_plumbline, m) {
  m.attr("__version__") = PLUMBLINE_VERSION;
  add_errors(m);
  add_state(m);
  add_estimator(m);
  add_trajectory(m);
  add_run(m);
  add_evaluate(m);
  m.def("configurations", [] {
    std::vector<std::string> names;
    for (const Configuration& configuration : configurations()) names.emplace_back(configuration.name);
    return names;
  });
  // Where the pixels of an image are that add_frame reads.
  m.def("_pixels_at", [](const py::array& gray) {
    return reinterpret_cast<std::uintptr_t>(image_view<std::uint8_t>(gray, "gray").data);
  });
}
