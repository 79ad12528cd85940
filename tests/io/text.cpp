#include "plumbline/io/text.hpp"

#include <optional>
#include <string_view>

#include "catch.hpp"
#include "temporary_directory.hpp"

using namespace plumbline;
using namespace plumbline::io;

TEST_CASE("text: seconds are read exactly") {
  REQUIRE(parse_seconds("1403636624.363555584") == TimeNs{1403636624363555584});
  REQUIRE(parse_seconds("1305031229.5287") == TimeNs{1305031229528700000});
  REQUIRE(parse_seconds("1.037359e-01") == TimeNs{103735900});
  REQUIRE(parse_seconds("2.063096e+01") == TimeNs{20630960000});
  REQUIRE(parse_seconds("0.000000e+00") == TimeNs{0});
  REQUIRE(parse_seconds("7") == TimeNs{7000000000});
  REQUIRE(parse_seconds("-0.5") == TimeNs{-500000000});
  REQUIRE(parse_seconds(".25") == TimeNs{250000000});
  REQUIRE(parse_seconds("0.0000000014") == TimeNs{1});
  REQUIRE(parse_seconds("0.0000000015") == TimeNs{2});
  REQUIRE(parse_seconds("1e-12") == TimeNs{0});
}

TEST_CASE("text: what is no time") {
  for (const std::string_view text :
       {"", "-", ".", "abc", "1.2.3", "1e", "1e99", "nan", "inf", "12s", "--1", "99999999999999999999"}) {
    CAPTURE(text);
    REQUIRE(parse_seconds(text) == std::nullopt);
  }
}

TEST_CASE("text: numbers must be finite and nothing else") {
  REQUIRE(parse_finite("-1.5e3") == -1500.0);
  REQUIRE(parse_finite("+2") == 2.0);
  for (const std::string_view text : {"nan", "inf", "-inf", "1,5", "0x", "", "1e999"}) {
    CAPTURE(text);
    REQUIRE(parse_finite(text) == std::nullopt);
  }
}

TEST_CASE("text: rows have their line numbers; comments, blank lines and carriage returns are passed over") {
  const TemporaryDirectory directory;
  const auto file = directory.write("rows.csv", "# header\r\n\n1, 2,3\r\n  4\t5 6\n7,8,x");
  RowReader row(file);
  REQUIRE(row.next());
  REQUIRE((row.line() == 3 && row.size() == 3 && row[2] == "3" && row.has_commas()));
  REQUIRE(row.next());
  REQUIRE((row.line() == 4 && row.number(0) == 4 && !row.has_commas()));
  REQUIRE(row.next());
  REQUIRE(reports(message_of([&] { row.number(2); }), file, 5, "column 3: \"x\" is not a finite number"));
  REQUIRE(reports(message_of([&] { row.require_size(4); }), file, 5, "expected 4 columns, found 3"));
  REQUIRE(!row.next());
}

TEST_CASE("text: times whose differences would not fit") {
  const TemporaryDirectory directory;
  const auto file = directory.write("times.txt", "4000000000\n-4000000001\n9223372036\n9223372036854775807\n");
  RowReader row(file);
  REQUIRE(row.next());
  REQUIRE(row.time_in_seconds() == TimeNs{4'000'000'000'000'000'000});
  for (const int line : {2, 3}) {
    REQUIRE(row.next());
    REQUIRE(reports(message_of([&] { row.time_in_seconds(); }), file, line, "is more than 126 years from the epoch"));
  }
  REQUIRE(row.next());
  REQUIRE(reports(message_of([&] { row.time_in_nanoseconds(); }), file, 4, "is more than 126 years"));
}

TEST_CASE("text: files that cannot be read") {
  const TemporaryDirectory directory;
  REQUIRE(
      reports(message_of([&] { read_text(directory.path() / "none"); }), directory.path() / "none", 0, "no such file"));
  REQUIRE(reports(message_of([&] { read_text(directory.path()); }), directory.path(), 0, "not a regular file"));
}
