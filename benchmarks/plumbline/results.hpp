#pragma once
/// Files of results: what was measured, with date, commit, machine and command, as JSON; their tables, as Markdown.
/// `plumbline table` writes the tables of files that are there, and the pages of docs/results.

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

/// Of a command that measures.
struct ResultOptions {
  std::optional<std::filesystem::path> json, markdown;
  std::string commit;  ///< of the source; empty: unknown
};

/// Throws std::runtime_error where one of the files could not be written.
void check_results(const ResultOptions& options);

/// The members that all results have; `command` as it is shown.
nlohmann::json result_of(const char* kind, const std::string& command, const ResultOptions& options);

void write_results(const ResultOptions& options, const nlohmann::json& result);

/// A command line: words in quotes where a shell asks for them.
std::string command_line(const std::vector<std::string>& words);

/// Of the folder, as it is shown.
std::string name_of_recording(const std::filesystem::path& directory);

struct TableOptions {
  std::vector<std::filesystem::path> files;   ///< of results, or of comparisons
  std::optional<std::filesystem::path> page;  ///< template with marks where tables go
  std::string command;                        ///< that made a comparison, whose file does not have it
  ResultOptions outputs;
};

/// `plumbline table`: prints or writes tables; returns the exit status 0. Throws std::runtime_error.
int run_table(const TableOptions& options);
