#include "debug_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include <opencv2/imgcodecs.hpp>

#include "final_trajectory.hpp"
#include "format.hpp"
#include "frame_picture.hpp"
#include "plot.hpp"
#include "plumbline/io/trajectory_evaluation.hpp"
#include "plumbline/lie/plus.hpp"
#include "statistics.hpp"

namespace fs = std::filesystem;
namespace pl = plumbline;

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr std::array axes{"x", "y", "z"};

fs::path made(const fs::path& directory) {
  std::error_code error;
  if (fs::exists(directory, error) && !(fs::is_directory(directory, error) && fs::is_empty(directory, error)))
    throw std::runtime_error(directory.string() + ": exists and is not an empty folder");
  fs::create_directories(directory / "frames", error);
  if (error) throw std::runtime_error(directory.string() + ": cannot be made: " + error.message());
  return directory;
}

/// Of the length of the three components of the error that begin with `first`.
double sigma_of(const pl::Mat<double, 6, 6>& covariance, int first) {
  return std::sqrt(covariance.diagonal().segment<3>(first).sum());
}

std::string headline(std::size_t number, double t_s, const FrameOutput& output, const Inspection& now) {
  const pl::Health& health = now.estimate.health;
  std::string out = format("#%zu  %.3f s  ", number, t_s);
  if (output.refused) return out + "refused: " + name_of(*output.refused);
  out += name_of(health.state);
  if (health.reason != pl::HealthReason::none) out += std::string(", ") + name_of(health.reason);
  if (now.inertial && now.inertial->start.stage != pl::InitStage::done) {
    const pl::InitReport& start = now.inertial->start;
    out +=
        std::string(": ") + (start.stage == pl::InitStage::aligning ? name_of(start.alignment) : name_of(start.stage));
  }
  if (now.estimate.keyframe) out += "  keyframe";
  if (now.inertial && now.inertial->is_stationary) out += "  stationary";
  return out;
}

}  // namespace

DebugReport::DebugReport(const DebugOptions& options, std::string title, pl::io::Trajectory truth)
    : options_(options),
      title_(std::move(title)),
      truth_(std::move(truth)),
      frames_(made(options.directory) / "frames.csv") {}

void DebugReport::add(std::size_t number, pl::TimeNs t_ns, const cv::Mat& gray, const FrameOutput& output,
                      const Inspection& inspection) {
  const pl::HealthReason reason = inspection.estimate.health.reason;
  const bool was_of_use = reason != pl::HealthReason::imu_only && reason != pl::HealthReason::few_inliers;
  std::vector<std::vector<Mark>> marks;
  for (std::size_t k = 0; k < inspection.features.size() && !output.refused; ++k)
    marks.push_back(marks_of(before_ ? &before_->features[k] : nullptr, inspection.features[k], was_of_use));
  marks.resize(inspection.features.size());

  add_row(number, t_ns, output, inspection, marks);
  if (output.has_sound_pose())
    poses_.push_back({output.pose_ns(), output.estimate.T_world_body, output.estimate.covariance});
  if (output.has_sound_pose() && output.is_in_map) {
    if (!first_correction_) first_correction_ = output.S_map_world;
    in_map_.push_back({output.pose_ns(), output.T_map_body()});
    if (output.map_counts.relocalizations > relocalized_) relocalizations_.push_back(in_map_.back());
    relocalized_ = output.map_counts.relocalizations;
  }
  if (!output.refused) before_ = inspection;
  if (number % options_.every != 0) return;
  std::vector<Mark> all;
  for (const std::vector<Mark>& kind : marks) all.insert(all.end(), kind.begin(), kind.end());
  const double t_s = pl::seconds_between(times_.front(), t_ns);
  const std::string name = format("frames/%06zu.jpg", number);
  const fs::path file = options_.directory / name;
  if (!cv::imwrite(file.string(), frame_picture(gray, all, headline(number, t_s, output, inspection)),
                   {cv::IMWRITE_JPEG_QUALITY, 90}))
    throw std::runtime_error(file.string() + ": cannot be written");
  pictures_.push_back({times_.size() - 1, name});
}

void DebugReport::add_row(std::size_t number, pl::TimeNs t_ns, const FrameOutput& output, const Inspection& now,
                          const std::vector<std::vector<Mark>>& marks) {
  const pl::Estimate<double>& estimate = now.estimate;
  times_.push_back(t_ns);
  health_.push_back(output.health());
  frames_.set("frame", static_cast<double>(number));
  frames_.set("timestamp_ns", std::to_string(t_ns));
  frames_.set("t_s", pl::seconds_between(times_.front(), t_ns));
  frames_.set("health", name_of(output.health()));
  frames_.set("reason", name_of(estimate.health.reason));
  frames_.set("refused", output.refused ? name_of(*output.refused) : "");
  frames_.set("keyframe", estimate.keyframe);
  frames_.set("resets", estimate.resets);

  kinds_.clear();
  for (std::size_t k = 0; k < now.features.size(); ++k) {
    const FeatureInspection& features = now.features[k];
    const std::string kind = kinds_.emplace_back(features.name) + "_";
    frames_.set(kind + "landmarks", static_cast<double>(features.landmarks));
    const std::array<int, mark_states> counts = count_states(marks[k]);
    for (std::size_t i = 0; i < mark_states; ++i) frames_.set(kind + mark_state_names[i], counts[i]);
    std::vector<double> sigma, px;
    for (const Innovation& innovation : features.innovations) {
      sigma.push_back(innovation.sigma);
      px.push_back(innovation.px);
    }
    frames_.set(kind + "innovation_median_sigma", percentile(sigma, 0.5));
    frames_.set(kind + "innovation_p90_sigma", percentile(sigma, 0.9));
    frames_.set(kind + "innovation_median_px", percentile(px, 0.5));
    frames_.set(kind + "innovation_p90_px", percentile(px, 0.9));
  }

  const bool has_pose = output.has_pose();
  frames_.set("sigma_position_m", has_pose ? sigma_of(estimate.covariance, 3) : unknown);
  frames_.set("sigma_rotation_deg", has_pose ? degrees * sigma_of(estimate.covariance, 0) : unknown);
  frames_.set("readout_ms", 1e3 * now.readout_s);
  has_imu_ = now.inertial.has_value();
  if (has_imu_) {
    frames_.set("time_offset_ms", 1e3 * now.inertial->time_offset_s);
    frames_.set("turned_deg", degrees * now.inertial->turned.norm());
    frames_.set("moved_cm", 100 * now.inertial->moved.norm());
    const bool started = now.inertial->start.stage == pl::InitStage::done;
    pl::Vec<double, 9> motion = pl::Vec<double, 9>::Constant(unknown);
    const pl::Vec<double, 9> sigma = now.inertial->sigma.value_or(motion);
    if (started) motion << estimate.v_world_body, estimate.bias_gyro, estimate.bias_accel;
    constexpr std::array names{"velocity_", "bias_gyro_", "bias_accel_"};
    for (int i = 0; i < 9; ++i) {
      const std::string name =
          std::string(names[static_cast<std::size_t>(i / 3)]) + axes[static_cast<std::size_t>(i % 3)];
      frames_.set(name, motion[i]);
      frames_.set("sigma_" + name, sigma[i]);
    }
    add_inertial(*now.inertial);
  }
  frames_.set("track_ms", 1e3 * output.timing.track());
  frames_.set("estimate_ms", 1e3 * output.timing.estimate);
  frames_.set("map_ms", 1e3 * output.timing.map);
  frames_.set("total_ms", 1e3 * output.timing.total);
  frames_.set("map_learn_ms", 1e3 * output.map_timing.learn);
  frames_.set("map_query_ms", 1e3 * output.map_timing.query);
  frames_.set("map_verify_ms", 1e3 * output.map_timing.verify);
  frames_.set("map_solve_ms", 1e3 * output.map_timing.solve);
  frames_.end_row();
}

void DebugReport::add_inertial(const InertialInspection& inertial) {
  const pl::ImuCoverage& coverage = inertial.coverage;
  frames_.set("at_rest", inertial.is_stationary);
  const auto since_last = [&](double value) { return before_ ? value : unknown; };
  frames_.set("imu_missing", since_last(coverage.missing()));
  frames_.set("imu_gap_s", since_last(coverage.gap_s));
  frames_.set("imu_held_s", since_last(coverage.held_s));
  frames_.set("imu_frozen_s", since_last(coverage.frozen_s));
  frames_.set("imu_saturated_s", since_last(coverage.saturated_s));
  const pl::InitReport& start = inertial.start;
  const bool done = start.stage == pl::InitStage::done;
  const auto until_done = [&](double value) { return done ? unknown : value; };
  frames_.set("start_stage", name_of(start.stage));
  frames_.set("start_alignment", start.stage == pl::InitStage::aligning ? name_of(start.alignment) : "");
  frames_.set("start_features", until_done(start.features));
  frames_.set("start_parallax_deg", until_done(degrees * start.parallax_rad));
  frames_.set("start_inliers", until_done(start.inliers));
  frames_.set("start_excitation", until_done(start.excitation));
  frames_.set("start_gravity_norm", until_done(start.gravity_norm));
  frames_.set("start_gyro_residual_deg", until_done(degrees * start.gyro_residual));
  frames_.set("start_scale_sigma", until_done(start.scale_sigma));
}

DebugMap DebugReport::map_of_run(const MapSummary& map, const pl::io::MapContents& contents,
                                 const pl::io::Trajectory& estimate, const pl::io::Trajectory& truth) const {
  const auto in_map = [&](const pl::io::Trajectory& poses) {
    const pl::Sim3<double> S = first_correction_.value_or(pl::Sim3<double>());
    pl::io::Trajectory out;
    for (const pl::io::StampedPose& pose : poses) out.push_back({pose.t_ns, pl::io::aligned(S, pose.T_world_body)});
    return out;
  };
  DebugMap out{map,
               contents,
               in_map(estimate),
               in_map_,
               final_trajectory(estimate, map.corrections),
               in_map(truth),
               relocalizations_,
               {}};
  if (truth_.empty()) return out;
  const pl::io::Alignment alignment = has_imu_                   ? pl::io::Alignment::posyaw
                                      : contents.header.dim == 6 ? pl::io::Alignment::se3
                                                                 : pl::io::Alignment::sim3;
  for (const pl::io::Trajectory* poses : {&out.odometry, &out.causal, &out.final}) {
    try {
      out.ate_m.push_back(pl::io::evaluate_trajectory(truth_, *poses, {.alignment = alignment}).ape.translation.rmse);
    } catch (const std::runtime_error&) {
      out.ate_m.push_back(unknown);  // too few poses with a truth
    }
  }
  return out;
}

void DebugReport::finish(const std::string& summary, const std::optional<MapSummary>& map,
                         const pl::io::MapContents& contents) {
  frames_.close();
  if (times_.empty()) return;
  std::vector<TruthError> errors;
  if (!truth_.empty()) {
    errors = compare_with_truth(truth_, poses_, has_imu_).errors;
    write_errors(errors);
  }
  std::string text = summary;
  if (!errors.empty()) {
    text += format("\nroot mean square of the position error %.4f m, aligned by %s", position_rmse(errors),
                   has_imu_ ? "position and heading" : "the whole pose");
  }
  pl::io::Trajectory estimate, truth;  // both in the estimate's world
  if (!poses_.empty()) {
    for (const EstimatedPose& pose : poses_) estimate.push_back({pose.t_ns, pose.T_world_body});
    for (const TruthError& each : errors) {
      const auto pose = std::lower_bound(estimate.begin(), estimate.end(), each.t_ns,
                                         [](const pl::io::StampedPose& p, pl::TimeNs t) { return p.t_ns < t; });
      truth.push_back({each.t_ns, pl::plus(pose->T_world_body, each.error)});
    }
    draw_trajectories(options_.directory / "trajectory.png", truth, estimate, title_);
  }
  std::optional<DebugMap> run_map;
  if (map) run_map = map_of_run(*map, contents, estimate, truth);
  write_debug_page(options_.directory / "report.html",
                   {title_, text, frames_, times_, health_, pictures_, kinds_, has_imu_, errors, estimate, truth,
                    run_map ? &*run_map : nullptr});
}

void DebugReport::write_errors(const std::vector<TruthError>& errors) const {
  Table table(options_.directory / "error.csv");
  for (const TruthError& each : errors) {
    table.set("timestamp_ns", std::to_string(each.t_ns));
    table.set("t_s", pl::seconds_between(times_.front(), each.t_ns));
    table.set("position_error_m", each.error.tail<3>().norm());
    table.set("rotation_error_deg", degrees * each.error.head<3>().norm());
    for (int i = 0; i < 3; ++i)
      table.set(std::string("position_error_body_") + axes[static_cast<std::size_t>(i)] + "_m", each.error[i + 3]);
    for (int i = 0; i < 3; ++i)
      table.set(std::string("rotation_error_body_") + axes[static_cast<std::size_t>(i)] + "_deg",
                degrees * each.error[i]);
    table.set("nees_position", each.nees_position);
    table.set("nees_rotation", each.nees_rotation);
    table.set("nees_pose", each.nees_pose);
    table.end_row();
  }
  table.close();
}
