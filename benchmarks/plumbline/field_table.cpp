#include "field_table.hpp"

#include <string>

using nlohmann::json;

namespace {

/// A cell of a Markdown table has no bar and no line break, and nothing in it is markup.
std::string cell_of(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '|' || c == '*' || c == '_' || c == '<' || c == '[' || c == '`' || c == '\\') out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out;
}

std::string answer_of(const json& answer) {
  if (answer.is_null()) return "";
  std::string out = std::to_string(answer.at("status").get<int>()) + ": ";
  for (const json& line : answer.at("lines"))
    out += (&line == &answer.at("lines").front() ? "" : "<br>") + cell_of(line.get<std::string>());
  return out;
}

}  // namespace

void print_field(std::ostream& out, const json& inputs) {
  out << "| input | what it is | `plumbline doctor` | `plumbline run` |\n| --- | --- | --- | --- |\n";
  for (const json& input : inputs)
    out << "| `" << input.at("name").get<std::string>() << "` | " << cell_of(input.at("what").get<std::string>())
        << " | " << answer_of(input.at("doctor")) << " | " << answer_of(input.at("run")) << " |\n";
}
