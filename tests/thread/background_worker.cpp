#include "plumbline/thread/background_worker.hpp"

#include <thread>

#include "catch.hpp"

using namespace plumbline;

namespace {

struct Sum {
  int value = 0;  // not atomic: the worker's own until it is waited for
  std::thread::id ran_on;
  static void add(void* self) {
    Sum& sum = *static_cast<Sum*>(self);
    ++sum.value;
    sum.ran_on = std::this_thread::get_id();
  }
};

}  // namespace

TEST_CASE("background_worker: runs what it is given once, elsewhere, and what it wrote is there after wait") {
  BackgroundWorker worker;
  worker.wait();
  Sum sum;
  for (int i = 1; i <= 1'000; ++i) {
    worker.start(&Sum::add, &sum);
    worker.wait();
    REQUIRE(sum.value == i);
  }
  worker.wait();
  REQUIRE(sum.value == 1'000);
  REQUIRE(sum.ran_on != std::this_thread::get_id());
}

TEST_CASE("background_worker: its end waits for the work") {
  Sum sum;
  for (int i = 1; i <= 100; ++i) {
    { BackgroundWorker().start(&Sum::add, &sum); }
    REQUIRE(sum.value == i);
  }
}
