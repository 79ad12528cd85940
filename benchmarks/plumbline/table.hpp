#pragma once
/// A table that is written row by row as CSV and kept for plots. The first row decides on the columns.

#include <cmath>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

class Table {
 public:
  /// Rows appear in the file as they are ended: what ran until something failed is there.
  explicit Table(std::filesystem::path file) : file_(std::move(file)), out_(file_) {
    if (!out_) throw std::runtime_error(file_.string() + ": cannot be written");
  }

  /// A cell of the present row. Those of a row come in the order of the first row; NaN is an empty cell.
  void set(const std::string& column, double value) {
    char text[32] = "";
    if (!std::isnan(value)) std::snprintf(text, sizeof text, "%.7g", value);
    add(column, text, false, value);
  }
  void set(const std::string& column, const std::string& text) {
    add(column, text, true, std::numeric_limits<double>::quiet_NaN());
  }

  void end_row() {
    if (rows_++ == 0)
      for (std::size_t i = 0; i < columns_.size(); ++i) out_ << (i > 0 ? "," : "") << columns_[i].name;
    if (next_ != columns_.size()) throw std::logic_error(file_.string() + ": a row without " + columns_[next_].name);
    out_ << (rows_ == 1 ? "\n" : "") << line_ << '\n';
    line_.clear();
    next_ = 0;
  }

  void close() {
    out_.close();
    if (!out_) throw std::runtime_error(file_.string() + ": cannot be written (disk full?)");
  }

  std::size_t rows() const { return rows_; }
  /// Columns of numbers; texts are in the file alone.
  std::vector<std::string> names() const {
    std::vector<std::string> out;
    for (const Column& each : columns_)
      if (!each.is_text) out.push_back(each.name);
    return out;
  }
  /// Of the whole column; empty when there is none of that name.
  const std::vector<double>& numbers(const std::string& column) const {
    static const std::vector<double> none;
    for (const Column& each : columns_)
      if (each.name == column) return each.numbers;
    return none;
  }

 private:
  struct Column {
    std::string name;
    bool is_text;
    std::vector<double> numbers;
  };

  void add(const std::string& column, const std::string& text, bool is_text, double value) {
    if (rows_ == 0) columns_.push_back({column, is_text, {}});
    if (next_ >= columns_.size() || columns_[next_].name != column)
      throw std::logic_error(file_.string() + ": " + column + " is out of order");
    columns_[next_].numbers.push_back(value);
    line_ += (next_++ > 0 ? "," : "") + text;
  }

  std::filesystem::path file_;
  std::ofstream out_;
  std::vector<Column> columns_;
  std::string line_;
  std::size_t next_ = 0, rows_ = 0;
};
