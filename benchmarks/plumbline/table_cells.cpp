#include "table_cells.hpp"

#include <cmath>
#include <cstddef>
#include <sstream>

#include "format.hpp"
#include "statistics.hpp"

std::string meters(double value) {
  if (std::isnan(value)) return "-";
  if (std::isinf(value)) return "failed";
  return format("%.*f m", value < 0.1 ? 4 : value < 1 ? 3 : value < 100 ? 2 : 0, value);
}

std::string percent(double share) { return format("%.0f %%", std::floor(100 * share)); }

std::string milliseconds(const std::vector<double>& ms) { return ms.empty() ? "-" : format("%.1f", median(ms)); }

std::string number(const nlohmann::json& value, int decimals, double unit) {
  return value.is_null() ? "-" : format("%.*f", decimals, unit * value.get<double>());
}

std::string counted(std::size_t count, const char* what) {
  return format("%zu %s%s", count, what, count == 1 ? "" : "s");
}

std::string text_of_machine(const nlohmann::json& machine) {
  return format("%s, %zu cores, %.1f GiB, %s, %s, %s, plumbline %s", machine.at("cpu").get<std::string>().c_str(),
                machine.at("cores").get<std::size_t>(), machine.at("memory_gib").get<double>(),
                machine.at("os").get<std::string>().c_str(), machine.at("compiler").get<std::string>().c_str(),
                machine.at("build").get<std::string>().c_str(), machine.at("plumbline").get<std::string>().c_str());
}

std::string wrapped(const std::string& text) {
  std::istringstream words(text);
  std::string out, word;
  for (std::size_t column = 0; words >> word; column += word.size() + 1) {
    if (column > 0 && column + word.size() > 120) {
      out.back() = '\n';
      column = 0;
    }
    out += word + " ";
  }
  if (!out.empty()) out.back() = '\n';
  return out;
}
