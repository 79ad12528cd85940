#include "plumbline/io/printable.hpp"

#include <string>
#include <string_view>

#include "catch.hpp"
#include "plumbline/io/error.hpp"

using namespace plumbline::io;
using namespace std::string_view_literals;

TEST_CASE("printable: text stays as it is") {
  for (const std::string_view text : {"", "rgb/0.png: no such file", "Straße", "軌跡", "\\n", "🚁"})
    REQUIRE(printable(text) == text);
}

TEST_CASE("printable: control characters are spelled") {
  REQUIRE(printable("a\x1b[31mb\a") == "a\\x1b[31mb\\x07");
  REQUIRE(printable("two\nlines\tand\r") == "two\\nlines\\tand\\x0d");
  REQUIRE(printable("\0\x7f"sv) == "\\x00\\x7f");
  REQUIRE(printable("\xc2\x9b"
                    "31m\xc2\xa0") ==
          "\\xc2\\x9b31m\xc2\xa0");  // the CSI of two bytes, and a blank that does not break
}

TEST_CASE("printable: what is no UTF-8 is spelled") {
  REQUIRE(printable("\x9b\x80x") == "\\x9b\\x80x");
  REQUIRE(printable("\xe8\xbb") == "\\xe8\\xbb");
  REQUIRE(printable("\xc0\xaf") == "\\xc0\\xaf");  // a slash in too many bytes
}

TEST_CASE("printable: the error of a file is one line") {
  REQUIRE(std::string(ReadError("a\nb", 3, "\"\x1b\" is no number").what()) == "a\\nb:3: \"\\x1b\" is no number");
}
