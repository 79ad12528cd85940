#include "run_files.hpp"

#include <cmath>
#include <cstdio>
#include <string>

#include "final_trajectory.hpp"
#include "format.hpp"
#include "output_check.hpp"

namespace fs = std::filesystem;
namespace io = plumbline::io;
namespace pl = plumbline;

namespace {

void check_paths(const RunPaths& paths, const std::vector<fs::path>& inputs) {
  std::vector<NamedOutput> outputs;
  if (paths.trajectory) outputs.push_back({"--trajectory", *paths.trajectory});
  if (paths.timing) outputs.push_back({"--timing", *paths.timing});
  if (paths.states) outputs.push_back({"--states", *paths.states});
  if (paths.world) outputs.push_back({"--trajectory-world", *paths.world});
  if (paths.final) outputs.push_back({"--trajectory-final", *paths.final});
  if (paths.landmarks) outputs.push_back({"--landmarks", *paths.landmarks});
  if (paths.loops) outputs.push_back({"--loops", *paths.loops});
  if (paths.map) outputs.push_back({"--save-map", *paths.map});
  check_outputs(outputs, inputs);
}

const char* reason_of(const FrameOutput& output) {
  return output.refused ? name_of(*output.refused) : name_of(output.estimate.health.reason);
}

std::string state_header() {
  std::string header = "timestamp_ns,health,reason,keyframe,resets,tracked,p_x,p_y,p_z,q_x,q_y,q_z,q_w";
  for (const char* name : {"v", "bias_gyro", "bias_accel", "sigma_rotation", "sigma_position", "sigma_v",
                           "sigma_bias_gyro", "sigma_bias_accel"})
    for (const char* axis : {"_x", "_y", "_z"}) header += std::string(",") + name + axis;
  for (int i = 0; i < 6; ++i)
    for (int j = i; j < 6; ++j) header += format(",covariance_%d%d", i, j);
  header += ",readout_s,time_offset_s";
  for (const char* name : {"turned", "moved", "sigma_turned", "sigma_moved"})
    for (const char* axis : {"_x", "_y", "_z"}) header += std::string(",") + name + axis;
  return header + '\n';
}

/// Numbers as cells, or empty ones.
template <class Vector>
std::string cells(bool known, const Vector& values) {
  std::string out;
  for (Eigen::Index i = 0; i < values.size(); ++i) out += known ? format(",%.9g", values[i]) : ",";
  return out;
}

}  // namespace

RunFiles::RunFiles(const RunPaths& paths, const std::vector<fs::path>& inputs) {
  check_paths(paths, inputs);
  if (paths.trajectory) trajectory_.emplace(*paths.trajectory);
  if (paths.world) world_.emplace(*paths.world);
  if (paths.final) final_.emplace(*paths.final);
  if (paths.timing) timing_.emplace(*paths.timing);
  if (paths.states) states_.emplace(*paths.states);
  if (paths.landmarks) landmarks_.emplace(*paths.landmarks);
  if (paths.loops) loops_.emplace(*paths.loops);
  if (paths.map) map_.emplace(*paths.map);
  if (timing_) {
    timing_->stream()
        << "timestamp_ns,track_ms,estimate_ms,map_ms,total_ms,health,reason,sigma_position_m,"
           "sigma_rotation_deg,pyramid_ms,align_ms,follow_ms,map_learn_ms,map_query_ms,map_verify_ms,map_solve_ms\n";
  }
  if (states_) states_->stream() << state_header();
}

void RunFiles::add_timing(pl::TimeNs t_ns, const FrameOutput& output) {
  if (!timing_) return;
  const pl::FrameTiming& timing = output.timing;
  std::string row = format("%lld,%.4f,%.4f,%.4f,%.4f,", static_cast<long long>(t_ns), 1e3 * timing.track(),
                           1e3 * timing.estimate, 1e3 * timing.map, 1e3 * timing.total);
  row += std::string(name_of(output.health())) + ',' + reason_of(output);
  if (output.has_pose()) {
    const pl::Vec<double, 6> variance = output.estimate.covariance.diagonal();
    row += format(",%.6g,%.6g", std::sqrt(variance.tail<3>().sum()), degrees * std::sqrt(variance.head<3>().sum()));
  } else {
    row += ",,";
  }
  row += format(",%.4f,%.4f,%.4f", 1e3 * timing.pyramid, 1e3 * timing.align, 1e3 * timing.follow);
  const MapTiming& map = output.map_timing;
  row += format(",%.4f,%.4f,%.4f,%.4f", 1e3 * map.learn, 1e3 * map.query, 1e3 * map.verify, 1e3 * map.solve);
  timing_->stream() << row << '\n';
}

void RunFiles::add_state(pl::TimeNs t_ns, const FrameOutput& output, const Inspection& inspection) {
  const pl::Estimate<double>& estimate = output.estimate;
  const bool has_pose = output.has_pose();
  const bool has_motion = has_pose && inspection.inertial && inspection.inertial->start.stage == pl::InitStage::done;
  const bool has_sigmas = has_motion && inspection.inertial->sigma;
  const Eigen::Quaterniond& q = estimate.T_world_body.rotation().quaternion();
  std::string row = format("%lld,%s,%s,%d,%u,%d", static_cast<long long>(t_ns), name_of(output.health()),
                           reason_of(output), int(estimate.keyframe), estimate.resets, estimate.tracked);
  row += cells(has_pose, estimate.T_world_body.p());
  row += cells(has_pose, q.coeffs());  // x y z w
  row += cells(has_motion, estimate.v_world_body);
  row += cells(has_motion, estimate.bias_gyro);
  row += cells(has_motion, estimate.bias_accel);
  row += cells(has_pose, estimate.covariance.diagonal().cwiseSqrt().eval());
  row += cells(has_sigmas, has_sigmas ? *inspection.inertial->sigma : pl::Vec<double, 9>::Zero().eval());
  for (int i = 0; i < 6; ++i)
    for (int j = i; j < 6; ++j) row += has_pose ? format(",%.9g", estimate.covariance(i, j)) : ",";
  row += format(",%.9g", inspection.readout_s);
  row += inspection.inertial ? format(",%.9g", inspection.inertial->time_offset_s) : ",";
  for (const auto part : {&InertialInspection::turned, &InertialInspection::moved, &InertialInspection::sigma_turned,
                          &InertialInspection::sigma_moved})
    row += cells(inspection.inertial.has_value(),
                 inspection.inertial ? (*inspection.inertial).*part : pl::Vec<double, 3>::Zero().eval());
  states_->stream() << row << '\n';
}

void RunFiles::add_landmarks(const std::vector<pl::Vec<double, 3>>& points) {
  std::ofstream& out = landmarks_->stream();
  out << "ply\nformat ascii 1.0\nelement vertex " << points.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (const pl::Vec<double, 3>& p : points) out << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
}

void RunFiles::add_map(const std::vector<std::byte>& bytes) {
  map_->stream().write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}

void RunFiles::add_loops(const std::vector<MapLoop>& loops) {
  if (!loops_) return;
  loops_->stream() << "timestamp_i_ns,timestamp_j_ns,p_x,p_y,p_z,q_x,q_y,q_z,q_w,scale\n";
  for (const MapLoop& loop : loops) {
    loops_->stream() << format("%lld,%lld", static_cast<long long>(loop.i_ns), static_cast<long long>(loop.j_ns))
                     << cells(true, loop.S_i_j.t()) << cells(true, loop.S_i_j.rotation().quaternion().coeffs())
                     << format(",%.9g\n", loop.S_i_j.scale());
  }
}

void RunFiles::add_final(const std::vector<MapCorrection>& corrections) {
  if (!final_) return;
  for (const auto& pose : final_trajectory(poses_, corrections)) final_->add(pose);
}

void RunFiles::commit_tables() {
  for (auto* file : {&timing_, &states_})
    if (*file) (*file)->complete();
  for (auto* file : {&timing_, &states_})
    if (*file) (*file)->commit();
}

void RunFiles::commit_all() {
  for (auto* file : {&trajectory_, &world_, &final_})
    if (*file) (*file)->complete();
  for (auto* file : {&landmarks_, &loops_, &map_})
    if (*file) (*file)->complete();
  commit_tables();
  for (auto* file : {&landmarks_, &loops_, &map_})
    if (*file) (*file)->commit();
  for (auto* file : {&world_, &final_, &trajectory_})
    if (*file) (*file)->commit();
}
