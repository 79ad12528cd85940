#pragma once
/// An executor runs the keyframe task (estimator/keyframe_task.hpp), on which no published pose depends.
///
///   SynchronousExecutor        in the calling thread, before add_frame returns
///   thread/background_worker   in a thread of its own, until the next frame needs the result
///   a user's type              e.g. a task of the operating system, notified by `start`

#include <concepts>

namespace plumbline {

/// start   causes one call of run(context), at any time and from any thread, before the next wait() returns
/// wait    returns when that call has ended and its writes are visible; at once when nothing was started
/// start is not called again before wait. The estimates depend on neither time nor thread of the call. The destructor
/// waits as well, and what is not synchronous is not copied.
template <class E>
concept Executor = std::default_initializable<E> && requires(E& executor, void (*run)(void*), void* context) {
  executor.start(run, context);
  executor.wait();
};

/// No thread: the task ends before add_frame returns.
struct SynchronousExecutor {
  static void start(void (*run)(void*), void* context) { run(context); }
  static void wait() {}
};
static_assert(Executor<SynchronousExecutor>);

}  // namespace plumbline
