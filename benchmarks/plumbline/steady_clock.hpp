#pragma once
/// Elapsed time of this machine, as a clock of estimators.

#include <chrono>

struct SteadyClock {
  static double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }
};
