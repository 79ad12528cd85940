#include "compare_parts.hpp"

#include <stdexcept>
#include <system_error>

#include "compare_json.hpp"
#include "format.hpp"
#include "plumbline/io/output_file.hpp"
#include "plumbline/io/text.hpp"

namespace fs = std::filesystem;
using nlohmann::json;

CompareParts::CompareParts(const fs::path& result, const json& machine, std::size_t processes)
    : directory_(result.string() + ".parts"), circumstances_(text_of(machine) + format(" %zu", processes)) {
  std::error_code error;
  fs::create_directories(directory_, error);
  if (error) throw std::runtime_error(directory_.string() + ": cannot be made");
}

std::optional<json> CompareParts::find(const CompareJob& job) const {
  if (!fs::is_regular_file(file_of(job))) return std::nullopt;
  json part = json::parse(plumbline::io::read_text(file_of(job)), nullptr, false);
  if (!part.is_object() || part.value("key", "") != key_of(job)) return std::nullopt;
  return part;
}

void CompareParts::write(const CompareJob& job, const CompareRun& run) const {
  plumbline::io::OutputFile file(file_of(job));
  file.stream() << text_of({{"key", key_of(job)}, {"bytes", run.bytes}, {"run", run.json}});
  file.commit();
}

void CompareParts::remove(const std::vector<CompareJob>& jobs) const {
  std::error_code ignored;
  for (const CompareJob& job : jobs) {
    fs::remove(file_of(job), ignored);
    fs::remove(file_of(job).string() + ".part", ignored);  // of a run that was stopped while it wrote
  }
  fs::remove(directory_, ignored);
}

std::string CompareParts::key_of(const CompareJob& job) const {
  return circumstances_ + " " + job.configuration->name + " " + fingerprint(job.dataset->directory.string()) + " " +
         job.dataset->content + format(" %zu %.9f %.9f", job.repeat, job.begin_s, job.duration_s);
}

fs::path CompareParts::file_of(const CompareJob& job) const {
  return directory_ / (fingerprint(key_of(job)) + ".json");
}
