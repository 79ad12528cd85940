#include "results.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "compare_merge.hpp"
#include "compare_table.hpp"
#include "faults_table.hpp"
#include "field_table.hpp"
#include "machine.hpp"
#include "map_table.hpp"
#include "memory.hpp"
#include "misuse.hpp"
#include "nearest.hpp"
#include "output_check.hpp"
#include "plumbline/io/output_file.hpp"
#include "plumbline/io/printable.hpp"
#include "plumbline/io/text.hpp"
#include "relocalizations_table.hpp"
#include "starts_table.hpp"
#include "table_cells.hpp"

namespace io = plumbline::io;
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// A table by its name in a template, from results of one kind.
struct ResultTable {
  const char *name, *kind, *member;
  void (*print)(std::ostream& out, const json& member);
};

/// The first one of a kind is its own without a template.
constexpr std::array<ResultTable, 12> result_tables{{
    {"comparison", "comparison", "comparison", print_markdown},
    {"accuracy", "comparison", "comparison", print_accuracy},
    {"timing", "comparison", "comparison", print_timing},
    {"initialization", "initialization", "groups", print_initialization},
    {"faults", "faults", "groups", print_faults},
    {"relocalizations", "relocalizations", "groups", print_relocalizations},
    {"memory", "memory", "configurations", print_memory},
    {"field", "field", "inputs", print_field},
    {"map", "map", "map", print_map},
    {"map_laps", "map", "map", print_map_laps},
    {"map_lost", "map", "map", print_map_lost},
    {"map_recordings", "map", "map", print_map_recordings},
}};

const ResultTable& table_named(const std::string& name) {
  std::vector<std::string> known;
  for (const ResultTable& table : result_tables) {
    if (name == table.name) return table;
    known.emplace_back(table.name);
  }
  throw std::runtime_error(unknown_name("table", name, known));
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::array<char, 16> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d", &utc);
  return text.data();
}

/// Lists of one kind become one; comparisons are printed one after the other.
void print_result_table(std::ostream& out, const ResultTable& table, std::span<const json> results) {
  json all = json::array();
  std::size_t comparisons = 0;
  for (const json& result : results) {
    if (result.at("kind") != table.kind) continue;
    const json& member = result.at(table.member);
    if (member.is_array()) {
      all.insert(all.end(), member.begin(), member.end());
      continue;
    }
    if (comparisons++ > 0) out << '\n';
    table.print(out, member);
  }
  if (!all.empty())
    table.print(out, all);
  else if (comparisons == 0)
    throw std::runtime_error(std::string("none of the files has the results of table ") + table.name);
}

/// A command in lines of at most 120 columns.
std::string broken(const std::string& command) {
  std::istringstream words(command);
  std::string out, word;
  for (std::size_t column = 0; words >> word; column += word.size() + 1) {
    if (column > 0 && column + word.size() > 117) {
      out += "\\\n  ";
      column = 2;
    }
    out += word + " ";
  }
  out.back() = '\n';
  return out;
}

/// Date, commit, machine and commands.
void print_origin(std::ostream& out, std::span<const json> results) {
  std::string before, commands;
  const auto print_commands = [&] {
    if (!commands.empty()) out << "\n```sh\n" << commands << "```\n";
    commands.clear();
  };
  for (const json& result : results) {
    const std::string commit = result.at("commit").is_null() ? "unknown" : result.at("commit").get<std::string>();
    const std::string origin = wrapped("Date " + result.at("date").get<std::string>() + ", commit " + commit + ". " +
                                       text_of_machine(result.at("machine")) + ".");
    if (origin != before) {
      print_commands();
      out << (before.empty() ? "" : "\n") << origin;
    }
    before = origin;
    if (!result.at("command").is_null()) commands += broken(result.at("command").get<std::string>());
  }
  print_commands();
}

/// Each once, in the order of the files.
void print_all_tables(std::ostream& out, std::span<const json> results) {
  std::vector<std::string> done;
  for (const json& result : results) {
    const std::string kind = result.at("kind");
    if (std::find(done.begin(), done.end(), kind) != done.end()) continue;
    const auto table = std::find_if(result_tables.begin(), result_tables.end(),
                                    [&](const ResultTable& each) { return kind == each.kind; });
    if (table == result_tables.end()) throw std::runtime_error("results of an unknown kind: " + kind);
    if (!done.empty()) out << '\n';
    done.push_back(kind);
    print_result_table(out, *table, results);
  }
  out << '\n';
  print_origin(out, results);
}

/// The template with tables in place of its marks, lines of their own: <!-- table NAME --> and <!-- origin -->.
void print_page(std::ostream& out, const std::string& text, std::span<const json> results) {
  constexpr std::string_view begin = "<!-- table ", end = " -->";
  out << "<!-- Generated by docs/results/make.sh. Edit the template instead. -->\n\n";
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line == "<!-- origin -->")
      print_origin(out, results);
    else if (line.starts_with(begin) && line.ends_with(end))
      print_result_table(out, table_named(line.substr(begin.size(), line.size() - begin.size() - end.size())), results);
    else
      out << line << '\n';
  }
}

/// Without trajectories, series and landmarks: what tables are made of.
json without_series(json comparison) {
  for (json& run : comparison.at("runs"))
    for (const char* series : {"trajectory", "frame_series", "map"}) run.erase(series);
  for (json& dataset : comparison.at("datasets"))
    for (json& axis : dataset.at("truth")) axis = json::array();
  return comparison;
}

json read_result(const fs::path& file, const TableOptions& options) {
  json out = json::parse(io::read_text(file), nullptr, false);
  const auto refuse = [&](const char* why) { throw std::runtime_error(file.string() + ": " + why); };
  if (out.is_discarded()) refuse("is not JSON");
  const json name = out.is_object() ? out.value("format", json()) : json();
  if (name == "plumbline-compare") {
    json comparison = without_series(read_comparison(file));
    out = result_of("comparison", options.command, options.outputs);
    out["machine"] = comparison.at("machine");
    out["comparison"] = std::move(comparison);
    return out;
  }
  if (name != "plumbline-results") refuse("has no results of plumbline");
  if (out.value("version", json()) != 1) refuse("has results of another version than 1");
  return out;
}

bool needs_quotes(const std::string& word) {
  return word.empty() || word.find_first_of(" \t\n'\"\\*?[]$&;|<>()`#~!{}") != std::string::npos;
}

}  // namespace

std::string command_line(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) {
    if (!out.empty()) out += ' ';
    out += needs_quotes(word) ? "'" + word + "'" : word;
  }
  return out;
}

std::string name_of_recording(const fs::path& directory) {
  return io::printable(fs::weakly_canonical(fs::absolute(directory)).filename().string());
}

void check_results(const ResultOptions& options) {
  std::vector<NamedOutput> outputs;
  if (options.json) outputs.push_back({"--json", *options.json});
  if (options.markdown) outputs.push_back({"--markdown", *options.markdown});
  check_outputs(outputs, {});
  for (const NamedOutput& output : outputs) {
    const fs::path folder = output.file.has_parent_path() ? output.file.parent_path() : ".";
    if (output.file.empty() || fs::is_directory(output.file) || access(folder.c_str(), W_OK) != 0)
      throw std::runtime_error(output.file.string() + ": cannot be written");
  }
}

json result_of(const char* kind, const std::string& command, const ResultOptions& options) {
  const auto text_or_null = [](const std::string& text) { return text.empty() ? json() : json(text); };
  return {{"format", "plumbline-results"},
          {"version", 1},
          {"kind", kind},
          {"date", today()},
          {"commit", text_or_null(options.commit)},
          {"command", text_or_null(command)},
          {"machine", describe_machine()}};
}

void write_results(const ResultOptions& options, const json& result) {
  const auto write = [](const std::optional<fs::path>& file, const auto& print) {
    if (!file) return;
    io::OutputFile output(*file);
    print(output.stream());
    output.commit();
  };
  write(options.json,
        [&](std::ostream& out) { out << result.dump(1, ' ', false, json::error_handler_t::replace) << '\n'; });
  write(options.markdown, [&](std::ostream& out) { print_all_tables(out, {&result, 1}); });
}

int run_table(const TableOptions& options) {
  check_results(options.outputs);
  try {
    std::vector<json> results;
    for (const fs::path& file : options.files) results.push_back(read_result(file, options));
    if (options.outputs.json) {
      if (results.size() != 1) throw Misuse("--json takes the results of one file");
      write_results({options.outputs.json, std::nullopt, {}}, results.front());
    }
    std::ostringstream text;
    if (options.page)
      print_page(text, io::read_text(*options.page), results);
    else
      print_all_tables(text, results);
    if (!options.outputs.markdown) {
      std::cout << text.str();
      return 0;
    }
    io::OutputFile output(*options.outputs.markdown);
    output.stream() << text.str();
    output.commit();
  } catch (const json::exception&) {
    throw std::runtime_error("table: a file has incomplete results");
  }
  return 0;
}
