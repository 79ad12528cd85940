#pragma once
/// Where the messages of `plumbline live` come from and estimates go to: standard input and output, or one connection
/// to a socket of this machine.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

class Connection {
 public:
  /// Standard input and output.
  Connection() = default;
  /// Waits for one sender. `address` is a port of 127.0.0.1 (0: a free one, which is printed) or the path of a Unix
  /// socket. Throws Interrupted, Misuse or std::runtime_error.
  explicit Connection(const std::string& address);
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection();

  int input() const { return in_; }
  /// Throws std::runtime_error where the other end is gone.
  void write(std::span<const std::uint8_t> bytes) const;

 private:
  int in_ = 0, out_ = 1;
  bool is_socket_ = false;
  std::filesystem::path path_;  ///< of a Unix socket
};
