#pragma once
/// Ctrl-C, and what a scheduler sends: work that is asked to stop removes its files and reports it.

#include <csignal>
#include <stdexcept>

/// The program's exit status is then 130, as a shell has it for SIGINT.
struct Interrupted : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// While it lives SIGINT, SIGTERM and SIGHUP are noted instead of ending the program; a second one ends it.
class Interruptible {
 public:
  Interruptible();
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;
  ~Interruptible();

  /// Whether one has come.
  static bool is_asked_to_stop();

 private:
  struct sigaction before_[3]{};
};
