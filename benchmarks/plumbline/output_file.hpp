#pragma once
/// A text file that appears under its name when it is complete: written as FILE.part, named in `commit`.

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <utility>

class OutputFile {
 public:
  explicit OutputFile(std::filesystem::path file) : file_(std::move(file)), part_(file_.string() + ".part") {
    if (std::filesystem::is_directory(file_)) throw std::runtime_error(file_.string() + ": is a directory");
    stream_.open(part_);
    if (!stream_) throw std::runtime_error(file_.string() + ": cannot be written");
  }
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile() {
    if (committed_) return;
    stream_.close();
    std::error_code ignored;
    std::filesystem::remove(part_, ignored);
  }

  std::ofstream& stream() { return stream_; }

  void commit() {
    stream_.close();
    if (!stream_) throw std::runtime_error(file_.string() + ": cannot be written (disk full?)");
    std::filesystem::rename(part_, file_);
    committed_ = true;
  }

 private:
  std::filesystem::path file_, part_;
  std::ofstream stream_;
  bool committed_ = false;
};
