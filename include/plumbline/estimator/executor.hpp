#pragma once
/// When the work runs that no pose waits for: what a frame needs to become a keyframe (estimator/keyframe_work.hpp).
///
///   InOrder                     before its frame's pose is published; nothing runs beside the caller
///   thread/background_worker    on a thread of its own, until the next frame needs what it makes
///   one of your own             e.g. a task of the operating system at hand, notified by `start`

#include <concepts>

namespace plumbline {

/// start   has run(context) called once, at any time and from any thread, but before the next wait() returns
/// wait    returns when it was called and all that it wrote can be read; at once when nothing was started
/// Nothing is started before what was started last is waited for. What an estimator computes depends on neither.
template <class E>
concept Executor = requires(E& executor, void (*run)(void*), void* context) {
  executor.start(run, context);
  executor.wait();
};

/// No executor at all: a keyframe's pose is published when all work is done, and is that of the bundle.
struct InOrder {
  static void start(void (*run)(void*), void* context) { run(context); }
  static void wait() {}
};
static_assert(Executor<InOrder>);

}  // namespace plumbline
