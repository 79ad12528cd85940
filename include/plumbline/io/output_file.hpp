#pragma once
/// A text file that appears under its name when it is complete: written as FILE.part, named in `commit`. Without
/// `commit` nothing is left, so that a run that failed half way leaves no file that looks complete.

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

namespace plumbline::io {

/// Throws std::runtime_error that names the file. What stands there and is no plain file (a device, a pipe, a link)
/// stays what it is: it is written directly.
class OutputFile {
 public:
  explicit OutputFile(std::filesystem::path file) : file_(std::move(file)), part_(file_) {
    if (std::filesystem::is_directory(file_)) throw std::runtime_error(file_.string() + ": is a directory");
    const std::filesystem::file_status status = std::filesystem::symlink_status(file_);
    if (!std::filesystem::exists(status) || std::filesystem::is_regular_file(status)) part_ += ".part";
    stream_.open(part_);
    if (!stream_) throw std::runtime_error(file_.string() + ": cannot be written");
  }
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile() {
    stream_.close();
    if (committed_ || part_ == file_) return;
    std::error_code ignored;
    std::filesystem::remove(part_, ignored);
  }

  std::ofstream& stream() { return stream_; }

  void commit() {
    stream_.close();
    if (!stream_) throw std::runtime_error(file_.string() + ": cannot be written (disk full?)");
    if (part_ != file_) std::filesystem::rename(part_, file_);
    committed_ = true;
  }

 private:
  std::filesystem::path file_, part_;
  std::ofstream stream_;
  bool committed_ = false;
};

}  // namespace plumbline::io
