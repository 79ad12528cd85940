#pragma once
/// Trajectories as files: TUM text, EuRoC ground truth CSV, KITTI rows; written as TUM text.
///                                                                                      docs/guide/your_recording.md

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "plumbline/core/time.hpp"
#include "plumbline/io/output_file.hpp"
#include "plumbline/io/text.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline::io {

struct StampedPose {
  TimeNs t_ns = 0;
  SE3<double> T_world_body;
};

using Trajectory = std::vector<StampedPose>;

namespace detail {

/// Position in columns i..i+2, quaternion in the four columns after it, its w first or last.
inline SE3<double> pose_in_columns(const RowReader& row, std::size_t i, bool w_first) {
  const std::size_t q = i + 3, w = w_first ? q : q + 3, x = w_first ? q + 1 : q;
  const Eigen::Quaterniond rotation(row.number(w), row.number(x), row.number(x + 1), row.number(x + 2));
  if (!(std::abs(rotation.norm() - 1) < 0.05)) row.fail("the quaternion is not of unit length");
  return SE3<double>(SO3<double>(rotation), Vec<double, 3>(row.number(i), row.number(i + 1), row.number(i + 2)));
}

/// A row-major 3x4 matrix [R p] in the twelve columns.
inline SE3<double> matrix_in_columns(const RowReader& row) {
  Mat<double, 3, 4> T;
  for (int i = 0; i < 12; ++i) T(i / 4, i % 4) = row.number(static_cast<std::size_t>(i));
  const Mat<double, 3, 3> R = T.leftCols<3>();
  if (!((R.transpose() * R - Mat<double, 3, 3>::Identity()).norm() < 0.05 && R.determinant() > 0))
    row.fail("the left 3x3 block is not a rotation");
  return SE3<double>(SO3<double>::from_matrix(R), T.col(3));
}

/// The times of KITTI rows: times.txt beside them, or else the row number in seconds.
inline std::vector<TimeNs> kitti_times(const std::filesystem::path& poses_file) {
  std::vector<TimeNs> times;
  const std::filesystem::path file = poses_file.parent_path() / "times.txt";
  if (!std::filesystem::exists(file)) return times;
  for (RowReader row(file); row.next();) times.push_back(row.time_in_seconds());
  return times;
}

}  // namespace detail

/// Reads a trajectory; the format is recognized by its rows:
///   12 columns         KITTI poses; times from times.txt beside the file when it has as many rows, else 0 s, 1 s ...
///   commas, 8 or more  EuRoC ground truth: t [ns], p, q (w x y z), anything
///   8 columns          TUM: t [s], p, q (x y z w)
/// Times must not decrease; of rows with the same time the last one counts. Throws ReadError.
inline Trajectory read_trajectory(const std::filesystem::path& file) {
  Trajectory out;
  RowReader row(file);
  std::size_t columns = 0;
  while (row.next()) {
    if (columns == 0) columns = row.size();
    row.require_size(columns);
    StampedPose pose;
    if (columns == 12) {
      pose = {static_cast<TimeNs>(out.size()) * 1'000'000'000, detail::matrix_in_columns(row)};
    } else if (row.has_commas() && columns >= 8) {
      pose = {row.time_in_nanoseconds(), detail::pose_in_columns(row, 1, true)};
    } else if (columns == 8) {
      pose = {row.time_in_seconds(), detail::pose_in_columns(row, 1, false)};
    } else {
      row.fail("neither TUM (8 columns), EuRoC (8 or more, with commas) nor KITTI (12): " + std::to_string(columns) +
               " columns");
    }
    if (!out.empty() && pose.t_ns < out.back().t_ns) row.fail("the time stamp is before that of the row above");
    if (!out.empty() && pose.t_ns == out.back().t_ns) out.pop_back();
    out.push_back(pose);
  }
  if (out.empty()) throw ReadError(file, 0, "no poses");
  if (columns == 12) {
    const std::vector<TimeNs> times = detail::kitti_times(file);
    if (times.size() == out.size())
      for (std::size_t i = 0; i < out.size(); ++i) out[i].t_ns = times[i];
  }
  return out;
}

/// The same motion of another frame fixed to the body: T_world_other = T_world_body T_body_other.
inline Trajectory moved_to(const Trajectory& trajectory, const SE3<double>& T_body_other) {
  Trajectory out = trajectory;
  for (StampedPose& pose : out) pose.T_world_body = pose.T_world_body * T_body_other;
  return out;
}

/// Writes a TUM trajectory row by row, as an OutputFile.
class TrajectoryWriter {
 public:
  explicit TrajectoryWriter(std::filesystem::path file) : file_(std::move(file)) {}

  void add(const StampedPose& pose) {
    const Vec<double, 3>& p = pose.T_world_body.p();
    const Eigen::Quaterniond& q = pose.T_world_body.rotation().quaternion();
    const long long t = pose.t_ns, ns = t < 0 ? -t : t;
    char row[256];
    std::snprintf(row, sizeof row, "%s%lld.%09lld %.9f %.9f %.9f %.12f %.12f %.12f %.12f\n", t < 0 ? "-" : "",
                  ns / 1'000'000'000, ns % 1'000'000'000, p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
    file_.stream() << row;
  }

  void complete() { file_.complete(); }
  void commit() { file_.commit(); }

 private:
  OutputFile file_;
};

}  // namespace plumbline::io
