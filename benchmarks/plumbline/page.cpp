#include "page.hpp"

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>

#include <nlohmann/json.hpp>

#include "pages.hpp"

void write_page(std::ostream& out, std::string_view page, const nlohmann::json& data) {
  constexpr std::string_view begin = "<script type=\"application/json\" id=\"plumbline-data\">", end = "null</script>";
  const std::string_view html = page_named(page);
  const std::size_t at = html.find(begin) + begin.size();
  if (at < begin.size() || !html.substr(at).starts_with(end))
    throw std::logic_error("page " + std::string(page) + ": no place for its data");

  out << html.substr(0, at);
  const std::string text = data.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  for (std::size_t i = 0; i < text.size();) {  // a `<` in a name must not end the script
    const std::size_t next = std::min(text.find('<', i), text.size());
    out << std::string_view(text).substr(i, next - i) << (next < text.size() ? "\\u003c" : "");
    i = next + 1;
  }
  out << html.substr(at + std::string_view("null").size());
}
