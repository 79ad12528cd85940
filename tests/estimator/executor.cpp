#include "plumbline/estimator/executor.hpp"

#include "catch.hpp"

using namespace plumbline;

namespace {
struct Count {
  int runs = 0;
  static void run(void* self) { ++static_cast<Count*>(self)->runs; }
};
struct WithoutWait {
  void start(void (*)(void*), void*) {}
};
struct Placed {  // the estimator has no arguments for it
  explicit Placed(int) {}
  void start(void (*)(void*), void*) {}
  void wait() {}
};
}  // namespace

TEST_CASE("executor: a synchronous one runs the task once before start returns, and waits for nothing") {
  Count count;
  SynchronousExecutor executor;
  executor.start(&Count::run, &count);
  CHECK(count.runs == 1);
  executor.wait();
  CHECK(count.runs == 1);
}

TEST_CASE("executor: it is started, waited for, and made without arguments") {
  STATIC_REQUIRE(Executor<SynchronousExecutor>);
  STATIC_REQUIRE_FALSE(Executor<WithoutWait>);
  STATIC_REQUIRE_FALSE(Executor<Placed>);
  STATIC_REQUIRE_FALSE(Executor<int>);
}
