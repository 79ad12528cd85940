#pragma once
/// Rows of numbers in text files: comma or blank separated, `#` starts a comment line, and the first row may be a
/// header without it. Times are read exactly: decimal
/// text becomes int64 nanoseconds without passing through a double, which has 200 ns steps at today's Unix times.

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "plumbline/core/time.hpp"
#include "plumbline/io/error.hpp"

namespace plumbline::io {

/// The whole file as text.
inline std::string read_text(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) throw ReadError(file, 0, "no such file");
  if (!std::filesystem::is_regular_file(file)) throw ReadError(file, 0, "not a regular file");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw ReadError(file, 0, "cannot be opened");
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (stream.bad()) throw ReadError(file, 0, "cannot be read");
  return text;
}

template <class Number>
std::optional<Number> parse(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// A finite number; empty for anything else, NaN and infinity included.
inline std::optional<double> parse_finite(std::string_view text) {
  const std::optional<double> value = parse<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

/// Units of time stamps; the value is the power of 1000 that a second has of them.
enum class TimeUnit { seconds = 0, milliseconds = 1, microseconds = 2, nanoseconds = 3 };

inline const char* name_of(TimeUnit unit) {
  constexpr const char* names[] = {"seconds", "milliseconds", "microseconds", "nanoseconds"};
  return names[static_cast<int>(unit)];
}

/// "1403636624.363555584" or "1.037359e-01" seconds as nanoseconds, exact; digits below 1 ns are rounded. With
/// `power`, the unit is 10^power seconds.
inline std::optional<TimeNs> parse_seconds(std::string_view text, int power = 0) {
  const std::size_t e = text.find_first_of("eE");
  const std::optional<int> exponent = e == text.npos ? 0 : parse<int>(text.substr(e + 1));
  std::string digits(text.substr(0, e));
  if (!exponent || std::abs(*exponent) > 40) return std::nullopt;
  int shift = *exponent + 9 + power;  // the number is the integer `digits` times 10^shift ns
  if (const std::size_t point = digits.find('.'); point != digits.npos) {
    shift -= static_cast<int>(digits.size() - point - 1);
    digits.erase(point, 1);
  }
  if (!parse<double>(digits)) return std::nullopt;  // nothing but a sign and digits
  const bool negative = digits.starts_with('-');
  if (negative || digits.starts_with('+')) digits.erase(0, 1);
  bool round_up = false;
  if (shift >= 0) {
    digits.append(static_cast<std::size_t>(shift), '0');
  } else {
    const std::size_t dropped = static_cast<std::size_t>(-shift);
    if (digits.size() < dropped) digits.insert(0, dropped - digits.size(), '0');
    round_up = digits[digits.size() - dropped] >= '5';
    digits.resize(digits.size() - dropped);
  }
  const std::optional<TimeNs> t = parse<TimeNs>(digits.empty() ? "0" : digits);
  if (!t || *t == std::numeric_limits<TimeNs>::max()) return std::nullopt;
  return (negative ? -1 : 1) * (*t + round_up);
}

/// Whether a first field is that of a header, such as "timestamp [ns]", "#t" without its mark, "%time" or
/// "field.stamp".
inline bool is_name_of_time(std::string_view field) {
  std::string name(field);
  for (char& c : name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  if (parse<double>(name)) return false;
  for (const char* part : {"time", "stamp", "sec"})
    if (name.find(part) != name.npos) return true;
  return name == "t" || name == "ts" || name == "\"t\"";
}

/// The rows of a text file with their line numbers; blank lines, comments, a header and a byte order mark are skipped.
class RowReader {
 public:
  explicit RowReader(const std::filesystem::path& file) : file_(file), text_(read_text(file)) {
    if (text_.starts_with("\xEF\xBB\xBF")) position_ = 3;
    if (text_.starts_with("\xFF\xFE") || text_.starts_with("\xFE\xFF"))
      throw ReadError(file, 1, "the text is UTF-16: save it as UTF-8");
  }

  /// False at the end of the file. The fields are valid as long as the reader.
  bool next() {
    while (position_ < text_.size()) {
      const std::size_t end = std::min(text_.find('\n', position_), text_.size());
      const std::string_view row(text_.data() + position_, end - position_);
      position_ = end + 1;
      ++line_;
      split(row);
      if (fields_.empty() || fields_[0].starts_with('#')) continue;
      const bool may_be_header = std::exchange(is_first_, false);
      if (!may_be_header || !is_name_of_time(fields_[0])) return true;
    }
    return false;
  }

  std::size_t size() const { return fields_.size(); }
  std::string_view operator[](std::size_t i) const { return fields_[i]; }
  bool has_commas() const { return has_commas_; }
  int line() const { return line_; }

  [[noreturn]] void fail(std::string_view what) const { throw ReadError(file_, line_, what); }
  void require_size(std::size_t n) const {
    if (size() != n) fail("expected " + std::to_string(n) + " columns, found " + std::to_string(size()));
  }
  double number(std::size_t i) const {
    const std::optional<double> value = parse_finite(fields_[i]);
    if (!value)
      fail("column " + std::to_string(i + 1) + ": \"" + std::string(fields_[i]) + "\" is not a finite number");
    return *value;
  }
  /// A number as others write it, but NaN or infinite.
  bool is_not_finite(std::size_t i) const {
    const std::optional<double> value = parse<double>(fields_[i]);
    return value && !std::isfinite(*value);
  }
  TimeNs time_in_seconds() const { return time(parse_seconds(fields_[0]), "in seconds"); }
  TimeNs time_in_nanoseconds() const { return time(parse<TimeNs>(fields_[0]), "in whole nanoseconds"); }
  TimeNs time_in(TimeUnit unit) const {
    if (unit == TimeUnit::seconds) return time_in_seconds();
    const int thousands = static_cast<int>(unit);
    if (unit == TimeUnit::nanoseconds && fields_[0].find_first_of(".eE") == std::string_view::npos)
      return time_in_nanoseconds();
    return time(parse_seconds(fields_[0], -3 * thousands), (std::string("in ") + name_of(unit)).c_str());
  }

 private:
  TimeNs time(std::optional<TimeNs> t, const char* unit) const {
    constexpr TimeNs farthest_ns = 4'000'000'000'000'000'000;  // differences stay within 64 bits
    if (!t) fail("\"" + std::string(fields_[0]) + "\" is not a time stamp " + unit);
    if (*t < -farthest_ns || *t > farthest_ns)
      fail("the time stamp " + std::string(fields_[0]) + " is more than 126 years from the epoch");
    return *t;
  }

  void split(std::string_view row) {
    has_commas_ = row.find(',') != row.npos;
    fields_.clear();
    for (std::size_t begin = 0; (begin = row.find_first_not_of(", \t\r", begin)) != row.npos;) {
      const std::size_t end = std::min(row.find_first_of(", \t\r", begin), row.size());
      fields_.push_back(row.substr(begin, end - begin));
      begin = end;
    }
  }

  std::filesystem::path file_;
  std::string text_;
  std::vector<std::string_view> fields_;
  std::size_t position_ = 0;
  int line_ = 0;
  bool has_commas_ = false, is_first_ = true;
};

}  // namespace plumbline::io
