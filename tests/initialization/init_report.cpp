#include "plumbline/initialization/init_report.hpp"

#include <set>
#include <string>

#include "catch.hpp"

using namespace plumbline;

TEST_CASE("init_report: every stage has a name of its own") {
  std::set<std::string> names;
  for (int k = 0; k <= int(InitStage::done); ++k) names.insert(name_of(InitStage(k)));
  REQUIRE(names.size() == std::size_t(InitStage::done) + 1);
  REQUIRE(names.count("unknown") == 0);
}

TEST_CASE("init_report: empty before the first frame") {
  const InitReport report;
  REQUIRE((report.stage == InitStage::few_features && report.features == 0 && report.rejected == 0));
  REQUIRE((report.alignment == AlignmentOutcome::too_few_frames && report.done_ns == 0));
}
