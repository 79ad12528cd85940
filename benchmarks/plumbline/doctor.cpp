#include "doctor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "format.hpp"
#include "motion_check.hpp"
#include "plumbline/io/output_file.hpp"
#include "plumbline/io/printable.hpp"
#include "recording_check.hpp"
#include "unused_sensors.hpp"

namespace pl = plumbline;
namespace io = plumbline::io;

namespace {

const char* name_of(DiagnosisLevel level) {
  constexpr std::array<const char*, 4> names{"OK", "NOTE", "WARN", "ERROR"};
  return names[static_cast<std::size_t>(level)];
}

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

}  // namespace

std::vector<Diagnosis> diagnose(const io::Recording& recording) {
  std::vector<Diagnosis> out;
  for (const std::string& note : recording.notes()) out.push_back({DiagnosisLevel::note, "files", note});
  for (const std::string& line : unusable_sensors(recording)) out.push_back({DiagnosisLevel::warning, "sensors", line});
  add_findings(recording, out);
  const bool is_sound = std::none_of(
      out.begin(), out.end(), [](const Diagnosis& diagnosis) { return diagnosis.level == DiagnosisLevel::error; });
  for (const Diagnosis& diagnosis : check_motion(recording, is_sound)) out.push_back(diagnosis);
  return out;
}

int run_doctor(const DoctorOptions& options) {
  const std::vector<Diagnosis> diagnoses = diagnose(options.inputs.open(options.dataset));
  nlohmann::json list = nlohmann::json::array();
  bool has_error = false;
  for (const Diagnosis& diagnosis : diagnoses) {
    std::printf("%-5s %-13s %s\n", name_of(diagnosis.level), diagnosis.check.c_str(),
                io::printable(diagnosis.text).c_str());
    list.push_back({{"level", name_of(diagnosis.level)}, {"check", diagnosis.check}, {"text", diagnosis.text}});
    has_error |= diagnosis.level == DiagnosisLevel::error;
  }
  if (options.json) {
    io::OutputFile file(*options.json);
    file.stream() << nlohmann::json{{"format", "plumbline-doctor"},
                                    {"version", 1},
                                    {"dataset", options.dataset.filename().string()},
                                    {"diagnoses", list}}
                         .dump(1)
                  << '\n';
    file.commit();
  }
  return has_error ? 1 : 0;
}
