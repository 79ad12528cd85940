#pragma once
/// A text file that appears under its name when it is complete: written beside it as FILE.part, named in `commit`.
/// Without `commit` nothing is left, so that a run that failed half way leaves no file that looks complete. Of several
/// files, `complete` all before the first `commit`: then either all appear or none.

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

namespace plumbline::io {

/// Throws std::runtime_error that names the file. An existing file that is not a regular one (a device, a pipe, a
/// symbolic link) is kept: it is written directly. An existing FILE.part is not overwritten.
class OutputFile {
 public:
  explicit OutputFile(std::filesystem::path file) : file_(std::move(file)), part_(file_) {
    if (file_.empty()) throw std::runtime_error("an output has an empty name");
    if (std::filesystem::is_directory(file_)) throw std::runtime_error(file_.string() + ": is a directory");
    const std::filesystem::file_status status = std::filesystem::symlink_status(file_);
    if (!std::filesystem::exists(status) || std::filesystem::is_regular_file(status)) part_ = new_file_beside(file_);
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

  /// All of it is on the disk, not yet under its name.
  void complete() {
    if (stream_.is_open()) stream_.close();
    if (!stream_) throw std::runtime_error(file_.string() + ": cannot be written (disk full?)");
  }

  void commit() {
    complete();
    std::error_code error;
    if (part_ != file_) std::filesystem::rename(part_, file_, error);
    if (error) throw std::runtime_error(file_.string() + ": cannot be written: " + error.message());
    committed_ = true;
  }

 private:
  /// FILE.part, made empty, or FILE.part2 ... where there is one.
  static std::filesystem::path new_file_beside(const std::filesystem::path& file) {
    for (int i = 1; i < 100; ++i) {
      std::filesystem::path part = file;
      part += ".part" + (i > 1 ? std::to_string(i) : std::string());
      if (std::FILE* made = std::fopen(part.c_str(), "wx")) {  // x: only if it is new
        std::fclose(made);
        return part;
      }
      if (errno != EEXIST) break;
    }
    throw std::runtime_error(file.string() + ": cannot be written");
  }

  std::filesystem::path file_, part_;
  std::ofstream stream_;
  bool committed_ = false;
};

}  // namespace plumbline::io
