#include "plumbline/state/health.hpp"

#include <set>
#include <string>

#include "catch.hpp"

using namespace plumbline;

namespace {

/// The names of all values up to the first that has none.
template <class E>
std::set<std::string> names(int& count) {
  std::set<std::string> out;
  for (count = 0; std::string(name_of(E(count))) != "unknown"; ++count) out.insert(name_of(E(count)));
  return out;
}

}  // namespace

TEST_CASE("health: every state and every reason has a name of its own") {
  int states = 0, reasons = 0;
  const auto state_names = names<HealthState>(states);
  const auto reason_names = names<HealthReason>(reasons);
  REQUIRE(int(state_names.size()) == states);
  REQUIRE(int(reason_names.size()) == reasons);
  REQUIRE(states > int(HealthState::lost));
  REQUIRE(reasons > int(HealthReason::imu_only));
  REQUIRE(std::string(name_of(HealthState(255))) == "unknown");
}

TEST_CASE("health: initializing before there is a pose") {
  REQUIRE(Health{}.state == HealthState::initializing);
  REQUIRE(Health{}.reason == HealthReason::none);
}
