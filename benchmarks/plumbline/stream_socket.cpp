#include "stream_socket.hpp"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <utility>

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "interrupt.hpp"
#include "misuse.hpp"

namespace {

[[noreturn]] void fail(const std::string& address, const char* what) {
  throw std::runtime_error(address + ": " + what + ": " + std::strerror(errno));
}

/// Ends with the scope, unless it is kept.
struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd >= 0) close(fd);
  }
};

int listen_at_port(const std::string& address) {
  if (address.size() > 5 || std::stoi(address) > 65535) throw Misuse(address + ": a port is at most 65535");
  Descriptor out{socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
  if (out.fd < 0) fail(address, "no socket");
  const int yes = 1;
  setsockopt(out.fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address)));
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof at;
  if (bind(out.fd, reinterpret_cast<const sockaddr*>(&at), size) != 0 || listen(out.fd, 1) != 0)
    fail(address, "cannot listen at this port of 127.0.0.1");
  getsockname(out.fd, reinterpret_cast<sockaddr*>(&at), &size);
  std::fprintf(stderr, "plumbline: note: waits for a sender at 127.0.0.1:%d\n", ntohs(at.sin_port));
  return std::exchange(out.fd, -1);
}

int listen_at_path(const std::string& address) {
  sockaddr_un at{};
  at.sun_family = AF_UNIX;
  if (address.size() >= sizeof at.sun_path) throw Misuse(address + ": too long for the path of a socket");
  std::copy(address.begin(), address.end(), at.sun_path);
  struct stat status {};
  if (lstat(address.c_str(), &status) == 0) {
    if (!S_ISSOCK(status.st_mode)) throw std::runtime_error(address + ": exists and is no socket");
    unlink(address.c_str());  // of an earlier run
  }
  Descriptor out{socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)};
  if (out.fd < 0) fail(address, "no socket");
  if (bind(out.fd, reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0 || listen(out.fd, 1) != 0)
    fail(address, "cannot listen at this path");
  std::fprintf(stderr, "plumbline: note: waits for a sender at %s\n", address.c_str());
  return std::exchange(out.fd, -1);
}

}  // namespace

Connection::Connection(const std::string& address) : is_socket_(true) {
  const bool is_port = !address.empty() && std::all_of(address.begin(), address.end(),
                                                       [](unsigned char c) { return std::isdigit(c) != 0; });
  const Descriptor listening{is_port ? listen_at_port(address) : listen_at_path(address)};
  if (!is_port) path_ = address;
  for (;;) {
    if (Interruptible::is_asked_to_stop()) {
      if (!path_.empty()) unlink(path_.c_str());
      throw Interrupted("interrupted before a sender came; nothing was written");
    }
    pollfd ready{listening.fd, POLLIN, 0};
    if (poll(&ready, 1, 100) <= 0) continue;
    in_ = out_ = accept4(listening.fd, nullptr, nullptr, SOCK_CLOEXEC);
    if (in_ >= 0) break;
  }
  const int yes = 1;
  if (is_port) setsockopt(in_, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
}

Connection::~Connection() {
  if (is_socket_ && in_ >= 0) close(in_);
  if (!path_.empty()) unlink(path_.c_str());
}

void Connection::write(std::span<const std::uint8_t> bytes) const {
  while (!bytes.empty()) {
    const ssize_t n =
        is_socket_ ? send(out_, bytes.data(), bytes.size(), MSG_NOSIGNAL) : ::write(out_, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) throw std::runtime_error(std::string("estimates cannot be written: ") + std::strerror(errno));
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
}
