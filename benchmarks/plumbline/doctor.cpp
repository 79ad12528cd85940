#include "doctor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "doctor_page.hpp"
#include "format.hpp"
#include "imu_noise_check.hpp"
#include "motion_check.hpp"
#include "output_check.hpp"
#include "page.hpp"
#include "plumbline/io/output_file.hpp"
#include "plumbline/io/printable.hpp"
#include "recording_check.hpp"
#include "unused_sensors.hpp"

namespace pl = plumbline;
namespace io = plumbline::io;

namespace {

/// Those that `run` makes before it begins.
void add_findings(const io::Recording& recording, std::vector<Diagnosis>& out) {
  const std::vector<Finding> findings = check_recording(recording, {recording.has_depth(), recording.has_imu()});
  for (const Finding& finding : findings)
    out.push_back({finding.is_error ? DiagnosisLevel::error : DiagnosisLevel::warning, "recording", finding.text});
  if (!findings.empty()) return;
  std::string text = format("%zu images", recording.frame_count());
  if (recording.has_depth()) text += " with depth";
  if (recording.has_imu()) text += format(", %zu IMU samples", recording.imu().size());
  out.push_back({DiagnosisLevel::ok, "recording", text + ": times, rates, units and contents are plausible"});
}

/// What --json writes, and the page has, too.
nlohmann::json json_of(const std::filesystem::path& dataset, const Examination& found) {
  nlohmann::json list = nlohmann::json::array();
  for (const Diagnosis& diagnosis : found.diagnoses)
    list.push_back({{"level", name_of(diagnosis.level)}, {"check", diagnosis.check}, {"text", diagnosis.text}});
  const nlohmann::json noise = found.noise ? doctor_noise(*found.noise) : nlohmann::json();
  return {{"format", "plumbline-doctor"},
          {"version", 1},
          {"dataset", std::filesystem::weakly_canonical(dataset).filename().string()},
          {"diagnoses", list},
          {"imu_noise", noise}};
}

void write_doctor_files(const DoctorOptions& options, const io::Recording& recording, const Examination& found) {
  nlohmann::json data = json_of(options.dataset, found);
  if (options.json) {
    io::OutputFile file(*options.json);
    file.stream() << data.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
    file.commit();
  }
  if (!options.report) return;
  data["series"] = doctor_series(recording, found.frames);
  data["noise_series"] = found.noise ? doctor_noise_series(*found.noise) : nlohmann::json();
  io::OutputFile file(*options.report);
  write_page(file.stream(), "doctor", data);
  file.commit();
}

}  // namespace

const char* name_of(DiagnosisLevel level) {
  constexpr std::array<const char*, 4> names{"OK", "NOTE", "WARN", "ERROR"};
  return names[static_cast<std::size_t>(level)];
}

Examination examine(const io::Recording& recording) {
  Examination found;
  std::vector<Diagnosis>& out = found.diagnoses;
  for (const std::string& note : recording.notes()) out.push_back({DiagnosisLevel::note, "files", note});
  for (const std::string& line : unusable_sensors(recording)) out.push_back({DiagnosisLevel::warning, "sensors", line});
  add_findings(recording, out);
  const bool is_sound = std::none_of(
      out.begin(), out.end(), [](const Diagnosis& diagnosis) { return diagnosis.level == DiagnosisLevel::error; });
  if (can_track(recording.calibration().camera)) found.frames = track_corners(recording);
  const auto append = [&](const std::vector<Diagnosis>& more) { out.insert(out.end(), more.begin(), more.end()); };
  append(check_motion(recording, found.frames, is_sound));
  if (recording.imu().size() < 2 || !is_sound) return found;
  append(check_saturation(recording));
  found.noise = measure_imu_noise(recording, found.frames);
  append(check_imu_noise(recording, *found.noise));
  return found;
}

int run_doctor(const DoctorOptions& options) {
  const io::Recording recording = options.inputs.open(options.dataset);
  std::vector<NamedOutput> outputs;
  if (options.json) outputs.push_back({"--json", *options.json});
  if (options.report) outputs.push_back({"--report", *options.report});
  check_outputs(outputs, recording.inputs());
  const Examination found = examine(recording);
  bool has_error = false;
  for (const Diagnosis& diagnosis : found.diagnoses) {
    std::printf("%-5s %-13s %s\n", name_of(diagnosis.level), diagnosis.check.c_str(),
                io::printable(diagnosis.text).c_str());
    has_error |= diagnosis.level == DiagnosisLevel::error;
  }
  write_doctor_files(options, recording, found);
  return has_error ? 1 : 0;
}
