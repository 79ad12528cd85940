namespace {
struct Failure {
  const char* text = nullptr;
  const char* file = nullptr;
  int line = 0;
  int count = 0;
};
Failure failure;
void report(const char* text, const char* file, int line) { failure = {text, file, line, failure.count + 1}; }
}  // namespace

#define PLUMBLINE_ASSERT_HANDLER(text, file, line) report(text, file, line)  // as firmware does
#include "plumbline/core/assert.hpp"

#include <string>

#include "catch.hpp"
#include "plumbline/core/fixed_vector.hpp"

TEST_CASE("assert: a replaced handler is called once, with file and line") {
  failure = {};
  int evaluations = 0;
  PLUMBLINE_ASSERT(++evaluations == 1);
  CHECK(failure.count == 0);
  const int line = __LINE__ + 1;
  PLUMBLINE_ASSERT(++evaluations == 5);
  CHECK(evaluations == 2);
  CHECK(failure.count == 1);
  CHECK(failure.line == line);
  CHECK(std::string(failure.text) == "++evaluations == 5");
  CHECK(std::string(failure.file).find("assert.cpp") != std::string::npos);
}

TEST_CASE("assert: guards the containers") {
  failure = {};
  plumbline::FixedVector<int, 2> v;
  v.push_back(1);
  CHECK(v[0] == 1);
  CHECK(failure.count == 0);
  static_cast<void>(v[1]);
  CHECK(failure.count == 1);
}
