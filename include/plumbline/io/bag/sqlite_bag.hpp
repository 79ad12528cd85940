#pragma once
/// Bags of ROS 2 in an SQLite database: tables `topics` and `messages`. Messages are read in the order of their
/// numbers, and of images the first bytes only, until their pixels are needed.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <sqlite3.h>

#include "plumbline/io/bag/bag_file.hpp"
#include "plumbline/io/bag/bag_reader.hpp"
#include "plumbline/io/error.hpp"

namespace plumbline::io::bag {

inline constexpr std::string_view sqlite_magic("SQLite format 3\0", 16);

class SqliteBag final : public BagReader {
 public:
  /// Throws ReadError where there is nothing to read.
  explicit SqliteBag(const std::filesystem::path& path) : size_(std::filesystem::file_size(path)) {
    read_stated_size(path);
    sqlite3* opened = nullptr;
    const int status = sqlite3_open_v2(path.c_str(), &opened, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, nullptr);
    database_.reset(opened);
    if (status != SQLITE_OK) throw ReadError(path, 0, "cannot be opened: " + text_of_error());
    sqlite3_limit(opened, SQLITE_LIMIT_LENGTH, 1 << 28);  // bytes of a message
    sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_db_config(opened, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_set_authorizer(opened, refuse_recursion, nullptr);
    try {
      read_topics();
      messages_ = prepare("SELECT id, topic_id, length(data) FROM messages ORDER BY id");
    } catch (const Damage& damage) {
      throw ReadError(path, 0, std::string("not a bag of ROS 2, or damaged: ") + damage.what());
    }
  }

  std::optional<MessagePlace> next() override {
    for (;;) {
      const int status = sqlite3_step(messages_.get());
      if (status == SQLITE_DONE) return std::nullopt;
      if (status != SQLITE_ROW) throw damage();
      const auto topic = topic_of_id_.find(sqlite3_column_int64(messages_.get(), 1));
      const sqlite3_int64 size = sqlite3_column_int64(messages_.get(), 2);
      const sqlite3_int64 id = sqlite3_column_int64(messages_.get(), 0);
      if (id <= last_) throw Damage(Damage::no_offset, "the messages after " + std::to_string(last_) + " are damaged");
      last_ = id;
      if (topic == topic_of_id_.end())
        throw Damage(Damage::no_offset, "message " + std::to_string(last_) + " belongs to no topic");
      return MessagePlace{topic->second,
                          {0, Place::no_container, static_cast<std::uint64_t>(id), static_cast<std::uint64_t>(size)}};
    }
  }

  Bytes read(const Place& place, std::size_t at_most) override {
    sqlite3_blob* opened = nullptr;
    const int status = sqlite3_blob_open(database_.get(), "main", "messages", "data",
                                         static_cast<sqlite3_int64>(place.offset), 0, &opened);
    const std::unique_ptr<sqlite3_blob, int (*)(sqlite3_blob*)> blob(opened, sqlite3_blob_close);
    if (status != SQLITE_OK) throw damage();
    const auto size = static_cast<std::uint64_t>(std::max(sqlite3_blob_bytes(opened), 0));
    if (size > size_) throw Damage(Damage::no_offset, "a message states more bytes than the file has");
    buffer_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(size, at_most)));
    if (sqlite3_blob_read(opened, buffer_.data(), static_cast<int>(buffer_.size()), 0) != SQLITE_OK) throw damage();
    return buffer_;
  }

 private:
  struct Close {
    void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };
  using Statement = std::unique_ptr<sqlite3_stmt, Close>;

  /// A view with a recursive query could take forever.
  static int refuse_recursion(void*, int action, const char*, const char*, const char*, const char*) {
    return action == SQLITE_RECURSIVE ? SQLITE_DENY : SQLITE_OK;
  }

  std::string text_of_error() const { return database_ ? sqlite3_errmsg(database_.get()) : "out of memory"; }
  /// At the end of the file where it is shorter than its header says, else by the number of the last message.
  Damage damage() const {
    if (size_ < stated_size_)
      return Damage(size_, "the database ends early: its header states " + std::to_string(stated_size_) + " bytes");
    return Damage(Damage::no_offset, "after message " + std::to_string(last_) + ": " + text_of_error());
  }
  Statement prepare(const char* text) {
    sqlite3_stmt* statement = nullptr;
    if (sqlite3_prepare_v2(database_.get(), text, -1, &statement, nullptr) != SQLITE_OK) throw damage();
    return Statement(statement);
  }
  static std::string text_at(const Statement& statement, int column) {
    const unsigned char* text = sqlite3_column_text(statement.get(), column);
    return text == nullptr ? "" : reinterpret_cast<const char*>(text);
  }

  /// Page size and number of pages, big endian, are in the header.
  void read_stated_size(const std::filesystem::path& path) {
    BagFile file(path);
    if (file.size() < 32) return;
    std::uint8_t head[32];
    file.read(0, head, sizeof head);
    const std::uint64_t page = 256U * head[16] + head[17],
                        pages = (std::uint64_t{head[28]} << 24) + (head[29] << 16) + (head[30] << 8) + head[31];
    stated_size_ = (page == 1 ? 65536 : page) * pages;
  }

  void read_topics() {
    const Statement statement = prepare("SELECT id, name, type, serialization_format FROM topics");
    int status = SQLITE_ROW;
    while ((status = sqlite3_step(statement.get())) == SQLITE_ROW) {
      const std::string format = text_at(statement, 3), type = text_at(statement, 2);
      topic_of_id_[sqlite3_column_int64(statement.get(), 0)] =
          topic_index({text_at(statement, 1), format == "cdr" ? type : type + " (" + format + ")", Serialization::cdr});
    }
    if (status != SQLITE_DONE) throw damage();
  }

  std::uint64_t size_;
  std::unique_ptr<sqlite3, Close> database_;
  Statement messages_;
  std::map<sqlite3_int64, std::size_t> topic_of_id_;
  std::vector<std::uint8_t> buffer_;
  std::uint64_t stated_size_ = 0;
  sqlite3_int64 last_ = std::numeric_limits<sqlite3_int64>::min();
};

}  // namespace plumbline::io::bag
