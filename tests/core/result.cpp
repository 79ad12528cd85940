#include "plumbline/core/result.hpp"

#include <set>
#include <string>

#include "catch.hpp"

using namespace plumbline;

namespace {

struct Estimate {
  int value;
};

Result<Estimate> serve(bool late) {
  if (late) return Error::late_sample;
  return Estimate{3};
}

}  // namespace

TEST_CASE("result: holds a value or an error") {
  const Result<Estimate> good = serve(false), bad = serve(true);
  REQUIRE(good);
  CHECK(good->value == 3);
  CHECK((*good).value == 3);
  REQUIRE(!bad);
  CHECK(bad.error() == Error::late_sample);
}

TEST_CASE("result: usable at compile time") {
  static_assert(Result<int>(4) && *Result<int>(4) == 4);
  static_assert(!Result<int>(Error::not_finite) && Result<int>(Error::not_finite).error() == Error::not_finite);
}

TEST_CASE("result: every error has a name of its own") {
  std::set<std::string> names;
  int count = 0;
  for (int i = 0; i < 64 && std::string(name_of(static_cast<Error>(i))) != "unknown error"; ++i, ++count) {
    names.insert(name_of(static_cast<Error>(i)));
  }
  CHECK(count >= 6);
  CHECK(int(names.size()) == count);
  CHECK(std::string(name_of(static_cast<Error>(200))) == "unknown error");
}
