#pragma once
/// A YAML mapping with its file: every error names the line, and an unknown key is an error that suggests
/// the key that was probably meant.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "plumbline/io/nearest.hpp"
#include "plumbline/io/text.hpp"

namespace plumbline::io {

/// What a number may be, both ends included.
struct Range {
  double low, high;
  const char* unit = "";  ///< with a blank before it

  bool contains(double value) const { return value >= low && value <= high; }  // not NaN
  std::string text() const {
    char out[96];
    std::snprintf(out, sizeof out, "from %g to %g%s", low, high, unit);
    return out;
  }
};

class YamlMap {
 public:
  /// The root of a file. OpenCV's and EuRoC's first line "%YAML:1.0" is no YAML directive and is skipped.
  explicit YamlMap(const std::filesystem::path& file) : YamlMap(file, read_text(file)) {}
  /// Of a text, which errors call `file`.
  YamlMap(const std::filesystem::path& file, std::string text) : file_(file) {
    if (text.starts_with("%YAML:")) text[0] = '#';
    try {
      node_ = YAML::Load(text);
    } catch (const YAML::Exception& error) {
      throw ReadError(file, error.mark.is_null() ? 0 : error.mark.line + 1, "not valid YAML: " + error.msg);
    }
    if (!node_.IsMap()) throw ReadError(file, 0, "not a YAML mapping (key: value)");
  }

  bool has(const char* key) const { return static_cast<bool>(node_[key]); }

  /// Every key must be one of `known` and appear once.
  void allow_only(std::initializer_list<std::string_view> known) const {
    std::vector<std::string> seen;
    for (const auto& entry : node_) {
      const std::string key = entry.first.Scalar();
      if (std::find(known.begin(), known.end(), key) == known.end()) {
        fail(entry.first, "unknown key \"" + key + "\", " + suggestion(key, known));
      }
      if (std::find(seen.begin(), seen.end(), key) != seen.end())
        fail(entry.first, "key \"" + key + "\" appears twice");
      seen.push_back(key);
    }
  }

  YamlMap map(const char* key) const {
    const YAML::Node child = required(key);
    if (!child.IsMap()) fail(child, name(key) + " must be a mapping (key: value)");
    return YamlMap(file_, child, name(key) + ".");
  }
  /// Number of items of a list; 0 where the key is missing.
  std::size_t size(const char* key) const { return has(key) && node_[key].IsSequence() ? node_[key].size() : 0; }
  /// Item `i` of a list of mappings.
  YamlMap item(const char* key, std::size_t i) const {
    const YAML::Node list = required(key);
    const std::string full = name(key) + "[" + std::to_string(i) + "]";
    if (!list.IsSequence() || i >= list.size()) fail(list, full + " is missing");
    if (!list[i].IsMap()) fail(list[i], full + " must be a mapping (key: value)");
    return YamlMap(file_, list[i], full + ".");
  }
  std::vector<std::string> keys() const {
    std::vector<std::string> out;
    for (const auto& entry : node_) out.push_back(entry.first.Scalar());
    return out;
  }
  std::string text(const char* key) const {
    const YAML::Node child = required(key);
    if (!child.IsScalar()) fail(child, name(key) + " must be a word");
    return child.Scalar();
  }
  /// A list of words.
  std::vector<std::string> texts(const char* key) const {
    std::vector<std::string> out;
    const YAML::Node list = required(key);
    if (!list.IsSequence()) fail(list, name(key) + " must be a list of words");
    for (const YAML::Node& item : list) {
      if (!item.IsScalar()) fail(item, name(key) + " must be a list of words");
      out.push_back(item.Scalar());
    }
    return out;
  }
  double number(const char* key) const { return number(required(key), key); }
  double number(const char* key, const Range& range) const {
    const double value = number(key);
    if (!range.contains(value)) fail(key, "must be " + range.text() + ", is " + text(key));
    return value;
  }
  double number_or(const char* key, const Range& range, double otherwise) const {
    return has(key) ? number(key, range) : otherwise;
  }
  int positive_integer(const char* key) const { return positive_integer(required(key), key); }

  /// A list of numbers, or of such lists: the rows of a matrix.
  std::vector<double> numbers(const char* key) const {
    std::vector<double> out;
    const YAML::Node list = required(key);
    if (!list.IsSequence()) fail(list, name(key) + " must be a list of numbers");
    for (const YAML::Node& row : list) {
      if (!row.IsSequence()) {
        append(row, key, out);
        continue;
      }
      for (const YAML::Node& item : row) append(item, key, out);
    }
    return out;
  }
  /// A matrix as `{rows, cols, data}` (EuRoC, OpenCV) or as a plain list.
  std::vector<double> matrix(const char* key) const {
    return required(key).IsMap() ? map(key).numbers("data") : numbers(key);
  }

  const std::filesystem::path& file() const { return file_; }
  /// "file:line: key what", for a note about a value that is no error.
  std::string note(const char* key, const std::string& what) const {
    YAML::Mark mark = YAML::Mark::null_mark();
    for (const auto& entry : node_)
      if (entry.first.Scalar() == key) mark = entry.first.Mark();
    return file_.string() + (mark.is_null() ? "" : ":" + std::to_string(mark.line + 1)) + ": " + name(key) + " " + what;
  }
  /// The value of `key` is wrong: names the key and its line.
  [[noreturn]] void fail(const char* key, const std::string& what) const { fail(node_[key], name(key) + " " + what); }
  [[noreturn]] void fail(const YAML::Node& node, const std::string& what) const {
    throw ReadError(file_, node.Mark().is_null() ? 0 : node.Mark().line + 1, what);
  }

 private:
  YamlMap(const std::filesystem::path& file, const YAML::Node& node, const std::string& prefix)
      : file_(file), node_(node), prefix_(prefix) {}

  std::string name(const char* key) const { return prefix_ + key; }

  YAML::Node required(const char* key) const {
    const YAML::Node child = node_[key];
    if (!child) {
      if (prefix_.empty()) throw ReadError(file_, 0, "key \"" + name(key) + "\" is missing");
      fail(node_, "key \"" + name(key) + "\" is missing");
    }
    return child;
  }
  double number(const YAML::Node& scalar, const char* key) const {
    const std::optional<double> value = scalar.IsScalar() ? parse_finite(scalar.Scalar()) : std::nullopt;
    if (!value)
      fail(scalar, name(key) + ": \"" + (scalar.IsScalar() ? scalar.Scalar() : "") + "\" is not a finite number");
    return *value;
  }
  int positive_integer(const YAML::Node& scalar, const char* key) const {
    const double value = number(scalar, key);
    if (!(value > 0 && value < 1e6 && value == std::floor(value)))
      fail(scalar, name(key) + " must be a positive whole number, is " + scalar.Scalar());
    return static_cast<int>(value);
  }
  void append(const YAML::Node& item, const char* key, std::vector<double>& out) const {
    constexpr std::size_t most = 100;  // of a calibration; aliases can make any number of a few lines
    if (item.IsSequence()) fail(item, name(key) + " is nested deeper than the rows of a matrix");
    if (out.size() == most) fail(item, name(key) + " has more than " + std::to_string(most) + " numbers");
    out.push_back(number(item, key));
  }

  std::filesystem::path file_;
  YAML::Node node_;
  std::string prefix_;
};

}  // namespace plumbline::io
