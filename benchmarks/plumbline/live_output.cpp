#include "live_output.hpp"

#include <cstdint>
#include <utility>
#include <vector>

#include "stream_message.hpp"

namespace pl = plumbline;

namespace {

template <class Vector>
nlohmann::ordered_json list_of(const Vector& values) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (Eigen::Index i = 0; i < values.size(); ++i) out.push_back(values[i]);
  return out;
}

/// Names of files may be no UTF-8.
std::string text_of(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::vector<std::uint8_t> payload_of(pl::TimeNs stamp_ns, const FrameOutput& output, std::size_t waiting) {
  const pl::Estimate<double>& estimate = output.estimate;
  const pl::SE3<double> T = output.T_map_body();
  std::vector<std::uint8_t> out;
  append_number(out, std::int64_t{stamp_ns});
  append_number(out, std::int64_t{output.pose_ns()});
  append_number(out, static_cast<std::uint32_t>(output.health()));
  append_number(out, static_cast<std::uint32_t>(estimate.health.reason));
  append_number(out,
                1u * output.has_pose() + 2u * (output.has_sound_pose() && output.is_in_map) + 4u * estimate.keyframe);
  append_number(out, static_cast<std::uint32_t>(estimate.tracked));
  append_number(out, estimate.resets);
  append_number(out, static_cast<std::uint32_t>(waiting));
  for (int i = 0; i < 3; ++i) append_number(out, T.p()[i]);
  for (int i = 0; i < 4; ++i) append_number(out, T.rotation().quaternion().coeffs()[i]);
  for (int i = 0; i < 3; ++i) append_number(out, estimate.v_world_body[i]);
  for (int i = 0; i < 6; ++i)
    for (int j = i; j < 6; ++j) append_number(out, estimate.covariance(i, j));
  append_number(out, 1e3 * output.timing.total);
  return out;
}

std::vector<std::uint8_t> map_payload_of(const FrameOutput& output) {
  const pl::Sim3<double>& S = output.S_map_world;
  std::vector<std::uint8_t> out;
  append_number(out, 1u * output.is_in_map);
  for (const int count : {output.map_counts.loops, output.map_counts.relocalizations, output.map_counts.corrections})
    append_number(out, static_cast<std::uint32_t>(count));
  append_number(out, S.scale());
  for (int i = 0; i < 3; ++i) append_number(out, S.t()[i]);
  for (int i = 0; i < 4; ++i) append_number(out, S.rotation().quaternion().coeffs()[i]);
  return out;
}

nlohmann::ordered_json json_of_map(const FrameOutput& output) {
  const pl::Sim3<double>& S = output.S_map_world;
  return {{"is_in_map", output.is_in_map},
          {"loops", output.map_counts.loops},
          {"relocalizations", output.map_counts.relocalizations},
          {"corrections", output.map_counts.corrections},
          {"scale", S.scale()},
          {"position", list_of(S.t())},
          {"quaternion", list_of(S.rotation().quaternion().coeffs())}};
}

}  // namespace

nlohmann::ordered_json json_of(pl::TimeNs stamp_ns, const FrameOutput& output, std::size_t waiting, bool has_map) {
  const pl::Estimate<double>& estimate = output.estimate;
  nlohmann::ordered_json out{{"stamp_ns", stamp_ns},
                             {"t_ns", output.pose_ns()},
                             {"health", name_of(output.health())},
                             {"reason", name_of(estimate.health.reason)},
                             {"has_pose", output.has_pose()},
                             {"is_sound", output.has_sound_pose() && output.is_in_map},
                             {"is_keyframe", estimate.keyframe},
                             {"tracked", estimate.tracked},
                             {"resets", estimate.resets},
                             {"waiting", waiting},
                             {"total_ms", 1e3 * output.timing.total}};
  if (has_map) out["map"] = json_of_map(output);
  if (!output.has_pose()) return out;
  const pl::SE3<double> T = output.T_map_body();
  out["position"] = list_of(T.p());
  out["quaternion"] = list_of(T.rotation().quaternion().coeffs());
  out["velocity"] = list_of(estimate.v_world_body);
  nlohmann::ordered_json covariance = nlohmann::ordered_json::array();
  for (int i = 0; i < 6; ++i)
    for (int j = i; j < 6; ++j) covariance.push_back(estimate.covariance(i, j));
  out["covariance"] = covariance;
  return out;
}

void LiveOutput::add(pl::TimeNs stamp_ns, const FrameOutput& output, std::size_t waiting) {
  if (!is_binary_) return write_line(json_of(stamp_ns, output, waiting, tells_map_));
  if (tells_map_) {
    std::vector<std::uint8_t> map = map_payload_of(output);
    if (map != map_) connection_.write(bytes_of(MessageType::map, 0, map));
    map_ = std::move(map);
  }
  connection_.write(bytes_of(MessageType::estimate, 0, payload_of(stamp_ns, output, waiting)));
}

void LiveOutput::add_event(const nlohmann::ordered_json& event) const {
  if (is_binary_) {
    const std::string text = text_of(event);
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(text.data());
    connection_.write(bytes_of(MessageType::event, 0, {bytes, text.size()}));
  } else {
    write_line(event);
  }
}

void LiveOutput::write_line(const nlohmann::ordered_json& line) const {
  const std::string text = text_of(line) + '\n';
  connection_.write({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}
