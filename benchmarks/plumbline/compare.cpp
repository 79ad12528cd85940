#include "compare.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "child_process.hpp"
#include "compare_json.hpp"
#include "compare_merge.hpp"
#include "compare_parts.hpp"
#include "compare_plan.hpp"
#include "compare_run.hpp"
#include "compare_table.hpp"
#include "machine.hpp"
#include "misuse.hpp"
#include "page.hpp"
#include "plumbline/io/output_file.hpp"
#include "plumbline/io/text.hpp"
#include "progress.hpp"

namespace io = plumbline::io;
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int interrupted = 130;  // exit status of shells after SIGINT

/// Part `index` (from 1) of `count`: every count-th run.
struct Shard {
  std::size_t index, count;

  explicit Shard(const std::string& text) {
    const std::size_t slash = text.find('/');
    const auto part =
        slash == text.npos ? std::nullopt : io::parse<std::size_t>(std::string_view(text).substr(0, slash));
    const auto parts =
        slash == text.npos ? std::nullopt : io::parse<std::size_t>(std::string_view(text).substr(slash + 1));
    if (!part || !parts || *part < 1 || *part > *parts)
      throw Misuse("--shard must be I/N with I from 1 to N, not " + text);
    index = *part;
    count = *parts;
  }
  bool has(std::size_t run) const { return run % count == index - 1; }
};

/// Before hours of work.
void check_outputs(const CompareOptions& options) {
  std::set<fs::path> files;
  for (const auto& file : {options.json, options.report, options.markdown}) {
    if (!file) continue;
    const fs::path folder = file->has_parent_path() ? file->parent_path() : ".";
    if (file->empty() || fs::is_directory(*file) || access(folder.c_str(), W_OK) != 0)
      throw std::runtime_error(file->string() + ": cannot be written");
    if (!files.insert(fs::weakly_canonical(fs::absolute(*file))).second)
      throw Misuse(file->string() + ": more than one output of that name");
  }
}

void write_outputs(const CompareOptions& options, const json& comparison) {
  const auto write = [](const std::optional<fs::path>& file, const auto& print) {
    if (!file) return;
    io::OutputFile output(*file);
    print(output.stream());
    output.commit();
  };
  write(options.json, [&](std::ostream& out) { out << text_of(comparison) << '\n'; });
  write(options.report, [&](std::ostream& out) { write_page(out, "compare", comparison); });
  write(options.markdown, [&](std::ostream& out) { print_markdown(out, comparison); });
}

std::string name_of(const CompareJob& job) {
  return job.configuration->name + (" on " + job.dataset->name) + format(", repeat %zu", job.repeat);
}

/// The header of the comparison, before the runs.
json comparison_of(const ComparePlan& plan, const CompareOptions& options, const json& machine, std::size_t processes) {
  std::string names;
  json configurations = json::array(), datasets = json::array();
  for (const Configuration* configuration : plan.configurations) configurations.push_back(json_of(*configuration));
  for (const CompareDataset& dataset : plan.datasets) datasets.push_back(dataset.json);
  for (const CompareJob& job : plan.jobs) names += name_of(job) + "\n";
  return {{"format", "plumbline-compare"},
          {"version", 1},
          {"machine", machine},
          {"processes", processes},
          {"part", {{"start_s", options.start_s}, {"duration_s", rounded(options.duration_s, 9)}}},
          {"plans", {{{"id", fingerprint(names)}, {"runs", plan.jobs.size()}}}},
          {"datasets", datasets},
          {"configurations", configurations},
          {"runs", json::array()}};
}

void add_run(json& comparison, const json& part) {
  comparison["runs"].push_back(part.at("run"));
  for (json& configuration : comparison["configurations"])
    if (configuration["name"] == part.at("run").at("configuration")) configuration["bytes"] = part.at("bytes");
}

json failed_run(const CompareJob& job, const std::string& why) {
  json run = json_of(job);
  run["error"] = why;
  return run;
}

std::size_t frames_of(const std::vector<CompareJob>& jobs) {
  std::size_t frames = 0;
  for (const CompareJob& job : jobs) frames += job.frames();
  return frames;
}

/// Runs what is not there yet. False when interrupted.
bool run_all(const std::vector<CompareJob>& jobs, const CompareParts& parts, const ChildLimits& limits,
             json& comparison) {
  std::vector<CompareJob> missing;
  for (const CompareJob& job : jobs) {
    if (const std::optional<json> part = parts.find(job))
      add_run(comparison, *part);
    else
      missing.push_back(job);
  }
  if (missing.size() < jobs.size())
    std::fprintf(stderr, "%zu of %zu runs are there already, in %s\n", jobs.size() - missing.size(), jobs.size(),
                 parts.directory().c_str());

  Progress progress(format("%zu runs, frames", missing.size()), frames_of(missing));
  std::size_t done = 0;
  const auto work = [&](std::size_t i) { parts.write(missing[i], run_compared(missing[i])); };
  const auto ended = [&](std::size_t i, const std::string& failure) {
    const CompareJob& job = missing[i];
    const std::optional<json> part = failure.empty() ? parts.find(job) : std::nullopt;
    const json run = part ? part->at("run") : failed_run(job, failure.empty() ? "left no result" : failure);
    if (run.at("status") != "ok") progress.note("failed: " + name_of(job) + ": " + run.at("error").get<std::string>());
    if (part)
      add_run(comparison, *part);
    else
      comparison["runs"].push_back(run);
    progress.show(done += job.frames());
  };
  return run_in_children(missing.size(), limits, work, ended);
}

int run_merge(const CompareOptions& options) {
  if (!options.configs.empty() || !options.datasets.empty())
    throw Misuse("--merge takes files of comparisons, no --config and no --dataset");
  const json comparison = merge_comparisons(options.merge);
  const std::size_t runs = comparison.at("runs").size(), planned = planned_runs(comparison);
  if (runs < planned) std::fprintf(stderr, "%zu of %zu runs: shards are missing\n", runs, planned);
  if (std::any_of(comparison.at("runs").begin(), comparison.at("runs").end(),
                  [](const json& run) { return run.contains("machine") || run.contains("processes"); }))
    std::fprintf(stderr, "runs of several machines, or of other numbers side by side: do not compare their times\n");
  try {
    write_outputs(options, comparison);
    print_table(std::cout, comparison);
  } catch (const json::exception&) {
    throw std::runtime_error("--merge: a file is not a whole comparison");
  }
  return 0;
}

void require_complete(const CompareOptions& options) {
  if (options.configs.empty() || options.datasets.empty() || !options.json)
    throw Misuse("compare needs --config, --dataset and --json, or --merge");
  if (!(options.limit_s > 0)) throw Misuse("--limit must be a time of more than 0 s");
}

}  // namespace

int run_compare(const CompareOptions& options) {
  check_outputs(options);
  if (!options.merge.empty()) return run_merge(options);
  require_complete(options);
  const Shard shard(options.shard);
  const ComparePlan plan(options);
  print_notes(plan.notes);
  for (const std::string& line : plan.left_out) std::fprintf(stderr, "%s\n", line.c_str());
  std::vector<CompareJob> jobs;
  for (std::size_t i = 0; i < plan.jobs.size(); ++i)
    if (shard.has(i)) jobs.push_back(plan.jobs[i]);

  const json machine = describe_machine();
  const std::size_t processes = options.processes > 0 ? options.processes : core_count();
  const CompareParts parts(*options.json, machine, processes);
  json comparison = comparison_of(plan, options, machine, processes);
  if (!run_all(jobs, parts, {processes, options.limit_s}, comparison)) {
    std::fprintf(stderr, "plumbline: interrupted; the same command goes on with what is in %s\n",
                 parts.directory().c_str());
    return interrupted;
  }
  finish(comparison);
  write_outputs(options, comparison);
  parts.remove(jobs);
  print_table(std::cout, comparison);
  return 0;
}
