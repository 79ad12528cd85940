#include "interrupt.hpp"

#include <array>

namespace {

constexpr std::array signals{SIGINT, SIGTERM, SIGHUP};
volatile std::sig_atomic_t signalled = 0;

extern "C" void note_signal(int) { signalled = 1; }

}  // namespace

Interruptible::Interruptible() {
  static_assert(std::size(decltype(before_){}) == signals.size());
  signalled = 0;
  struct sigaction note {};
  note.sa_handler = note_signal;
  note.sa_flags = static_cast<int>(SA_RESETHAND);
  for (std::size_t i = 0; i < signals.size(); ++i) {
    sigaction(signals[i], nullptr, &before_[i]);
    if (before_[i].sa_handler != SIG_IGN) sigaction(signals[i], &note, nullptr);  // nohup keeps its effect
  }
}

Interruptible::~Interruptible() {
  for (std::size_t i = 0; i < signals.size(); ++i) sigaction(signals[i], &before_[i], nullptr);
}

bool Interruptible::is_asked_to_stop() { return signalled != 0; }
