#pragma once
/// An executor (estimator/executor.hpp) without a thread: the keyframe task runs in the idle loop, or at the latest in
/// the next add_frame.
///
///   while (nothing to do) if (!vio.executor().work()) sleep until the next interrupt

#include "plumbline/estimator/executor.hpp"

class IdleExecutor {
 public:
  IdleExecutor() = default;
  IdleExecutor(const IdleExecutor&) = delete;
  IdleExecutor& operator=(const IdleExecutor&) = delete;

  void start(void (*run)(void*), void* context) {
    run_ = run;
    context_ = context;
  }
  void wait() { work(); }

  /// Runs the task; false when there is none.
  bool work() {
    if (run_ == nullptr) return false;
    void (*const run)(void*) = run_;
    run_ = nullptr;
    run(context_);
    return true;
  }

 private:
  void (*run_)(void*) = nullptr;
  void* context_ = nullptr;
};
static_assert(plumbline::Executor<IdleExecutor>);
