#include "machine.hpp"

#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <thread>

#include "compare_json.hpp"

namespace {

/// What follows the key and a separator in a file of lines; without quotes.
std::string value_in(const char* file, std::string_view key, char separator) {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    if (!line.starts_with(key)) continue;
    const std::size_t begin = line.find_first_not_of(" \t\"", line.find(separator) + 1);
    const std::size_t end = line.find_last_not_of(" \t\"");
    if (begin <= end) return line.substr(begin, end + 1 - begin);
  }
  return {};
}

utsname system_names() {
  utsname names{};
  uname(&names);
  return names;
}

std::string name_of_cpu() {
  const std::string model = value_in("/proc/cpuinfo", "model name", ':');
  return model.empty() ? system_names().machine : model;
}

std::string name_of_system() {
  const std::string distribution = value_in("/etc/os-release", "PRETTY_NAME", '=');
  return distribution.empty() ? system_names().sysname : distribution;
}

double memory_gib() {
  return static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE)) / (1 << 30);
}

std::string content_of_program() {
  std::ifstream stream("/proc/self/exe", std::ios::binary);
  return fingerprint(std::string{std::istreambuf_iterator<char>(stream), {}});
}

#ifdef __clang__
constexpr const char* compiler = "Clang " __clang_version__;
#else
constexpr const char* compiler = "GCC " __VERSION__;
#endif

}  // namespace

nlohmann::json describe_machine() {
  return {{"cpu", name_of_cpu()},           {"cores", core_count()},          {"memory_gib", rounded(memory_gib(), 1)},
          {"os", name_of_system()},         {"compiler", compiler},           {"build", PLUMBLINE_BUILD},
          {"plumbline", PLUMBLINE_VERSION}, {"program", content_of_program()}};
}

std::size_t core_count() { return std::max(1U, std::thread::hardware_concurrency()); }
