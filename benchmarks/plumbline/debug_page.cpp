#include "debug_page.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include <nlohmann/json.hpp>

#include "format.hpp"
#include "map_json.hpp"
#include "page.hpp"
#include "plumbline/io/output_file.hpp"

namespace pl = plumbline;
using Json = nlohmann::json;

namespace {

/// With the six digits that a chart can show; null where it does not exist.
Json number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return std::strtod(text, nullptr);  // NaN becomes null when it is written
}

Json numbers(const std::vector<double>& values) {
  Json out = Json::array();
  for (const double value : values) out.push_back(number(value));
  return out;
}

/// Seconds since the first frame, to the microsecond.
class SecondsSince {
 public:
  explicit SecondsSince(pl::TimeNs first) : first_(first) {}
  Json operator()(pl::TimeNs t) const { return std::round(1e-3 * static_cast<double>(t - first_)) / 1e6; }

 private:
  pl::TimeNs first_;
};

Json errors_of(const std::vector<TruthError>& errors, const SecondsSince& seconds) {
  if (errors.empty()) return nullptr;
  Json out;
  for (const TruthError& each : errors) {
    out["t"].push_back(seconds(each.t_ns));
    out["position_m"].push_back(number(each.error.tail<3>().norm()));
    out["rotation_deg"].push_back(number(degrees * each.error.head<3>().norm()));
    out["nees_pose"].push_back(number(each.nees_pose));
  }
  return out;
}

Json trajectory_of(const pl::io::Trajectory& trajectory, const SecondsSince& seconds) {
  Json out{{"t", Json::array()}, {"x", Json::array()}, {"y", Json::array()}, {"z", Json::array()}};
  for (const pl::io::StampedPose& pose : trajectory) {
    const pl::Vec<double, 3>& p = pose.T_world_body.p();
    out["t"].push_back(seconds(pose.t_ns));
    out["x"].push_back(number(p.x()));
    out["y"].push_back(number(p.y()));
    out["z"].push_back(number(p.z()));
  }
  return out;
}

Json map_of(const DebugMap& map, const SecondsSince& seconds) {
  Json out = json_of_map(map.contents);
  out["counts"] = json_of_counts(map.summary);
  out["odometry"] = trajectory_of(map.odometry, seconds);
  out["causal"] = trajectory_of(map.causal, seconds);
  out["final"] = trajectory_of(map.final, seconds);
  out["truth"] = trajectory_of(map.truth, seconds);
  out["relocalizations"] = trajectory_of(map.relocalizations, seconds);
  out["ate_m"] = nullptr;
  if (map.ate_m.size() == 3)
    out["ate_m"] = {
        {"odometry", number(map.ate_m[0])}, {"causal", number(map.ate_m[1])}, {"final", number(map.ate_m[2])}};
  return out;
}

}  // namespace

void write_debug_page(const std::filesystem::path& html, const DebugPage& page) {
  const SecondsSince seconds(page.times.front());
  Json data{{"format", "plumbline-debug"}, {"version", 1},        {"title", page.title},
            {"summary", page.summary},     {"kinds", page.kinds}, {"has_imu", page.has_imu}};
  for (const pl::TimeNs t : page.times) data["t"].push_back(seconds(t));
  for (const pl::HealthState state : page.health) data["health"].push_back(static_cast<int>(state));
  for (const std::string& column : page.frames.names()) data["columns"][column] = numbers(page.frames.numbers(column));
  data["errors"] = errors_of(page.errors, seconds);
  data["trajectory"] = trajectory_of(page.estimate, seconds);
  data["truth"] = trajectory_of(page.truth, seconds);
  data["map"] = page.map ? map_of(*page.map, seconds) : Json();
  data["pictures"] = Json::array();
  for (const DebugPage::Picture& picture : page.pictures)
    data["pictures"].push_back({{"row", picture.row}, {"file", picture.file}});

  pl::io::OutputFile file(html);
  write_page(file.stream(), "debug", data);
  file.commit();
}
