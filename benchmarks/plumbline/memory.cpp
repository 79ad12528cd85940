#include "memory.hpp"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "format.hpp"
#include "table_cells.hpp"

using nlohmann::json;

namespace {

std::string mebibytes(double bytes) { return format("%.1f MiB", bytes / 1048576); }

/// Names in the order in which they come.
void add_once(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

}  // namespace

int list_memory(const ResultOptions& options) {
  check_results(options);
  json result = result_of("memory", "plumbline list --memory", options);
  result["camera"] = "Pinhole<float, RadTan>";
  result["width"] = 752;
  result["height"] = 480;
  result["configurations"] = json::array();
  for (const FirmwareSize& size : firmware_sizes()) {
    result["configurations"].push_back({{"name", size.name}, {"bytes", size.bytes}});
    std::printf("%-34s %10zu bytes %10s\n", size.name, size.bytes, mebibytes(static_cast<double>(size.bytes)).c_str());
  }
  write_results(options, result);
  return 0;
}

void print_memory(std::ostream& out, const json& configurations) {
  std::vector<std::string> rows, columns;
  const auto split = [](const json& configuration) {
    const auto name = configuration.at("name").get<std::string>();
    const std::size_t slash = name.rfind('/');
    return std::pair(name.substr(0, slash), name.substr(slash + 1));
  };
  for (const json& each : configurations) {
    add_once(rows, split(each).first);
    add_once(columns, split(each).second);
  }
  out << "| sensors and features |";
  for (const std::string& column : columns) out << " `" << column << "` |";
  out << "\n| --- |";
  for (std::size_t i = 0; i < columns.size(); ++i) out << " --- |";
  out << '\n';
  for (const std::string& row : rows) {
    out << "| `" << row << "` |";
    for (const std::string& column : columns) {
      const auto found = std::find_if(configurations.begin(), configurations.end(),
                                      [&](const json& each) { return split(each) == std::pair(row, column); });
      if (found != configurations.end()) out << ' ' << mebibytes(found->at("bytes").get<double>());
      out << " |";
    }
    out << '\n';
  }
  out << '\n'
      << wrapped(
             "`sizeof` of the estimator in `float` with a pinhole camera with radial and tangential distortion and "
             "images of 752 x 480 pixels. It is all the memory that the estimator uses.");
}
