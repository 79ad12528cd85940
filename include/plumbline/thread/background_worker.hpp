#pragma once
/// An executor (estimator/executor.hpp) with a thread of its own, which sleeps while there is nothing to do:
///
///   using Vio = Estimator<Sensors, Features, DirectGaussNewton<10>, NoClock, NoMap, BackgroundWorker>;
///
/// The heap is used once, for the thread.

#include <atomic>
#include <thread>

#include "plumbline/core/assert.hpp"
#include "plumbline/estimator/executor.hpp"

namespace plumbline {

class BackgroundWorker {
 public:
  BackgroundWorker() : thread_([this] { work(); }) {}
  BackgroundWorker(const BackgroundWorker&) = delete;
  BackgroundWorker& operator=(const BackgroundWorker&) = delete;
  ~BackgroundWorker() {
    wait();
    become(State::ending);
    thread_.join();
  }

  void start(void (*run)(void*), void* context) {
    PLUMBLINE_ASSERT(state_.load() == State::idle);
    run_ = run;
    context_ = context;
    become(State::busy);
  }
  void wait() { state_.wait(State::busy); }

 private:
  enum class State : int { idle, busy, ending };

  /// A reader of it sees what was written before.
  void become(State state) {
    state_.store(state);
    state_.notify_all();
  }

  void work() {
    for (;;) {
      state_.wait(State::idle);
      if (state_.load() == State::ending) return;
      run_(context_);
      become(State::idle);
    }
  }

  std::atomic<State> state_ = State::idle;
  void (*run_)(void*) = nullptr;
  void* context_ = nullptr;
  std::thread thread_;  ///< the last: all else is there when it begins
};
static_assert(Executor<BackgroundWorker>);

}  // namespace plumbline
