#include "plumbline/io/bag/bag_file.hpp"

#include <string>
#include <vector>

#include "catch.hpp"
#include "plumbline/io/error.hpp"
#include "temporary_directory.hpp"

using namespace plumbline::io::bag;
using plumbline::io::ReadError;

namespace {

/// More than three windows of 64 KiB, no two of them alike.
std::string content() {
  std::string out;
  for (std::uint32_t i = 0; i < 200'001; ++i) out += static_cast<char>(i * 2654435761u >> 24);
  return out;
}
std::string text_of(const std::vector<std::uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

/// Offset of the Damage that the call throws; 1 if it throws none.
template <class F>
std::uint64_t damaged_at(F&& call) {
  try {
    call();
  } catch (const Damage& damage) {
    return damage.offset_bytes();
  }
  return 1;
}

}  // namespace

TEST_CASE("bag_file: any bytes in any order, across the ends of its window") {
  const TemporaryDirectory directory;
  const std::string all = content();
  BagFile file(directory.write("bytes", all));
  CHECK(file.size() == all.size());
  std::vector<std::uint8_t> bytes;
  for (const std::size_t offset : {150'000u, 0u, 65'530u, 131'071u, 3u, 199'990u, 65'536u}) {
    for (const std::size_t count : {0u, 1u, 11u}) {
      CAPTURE(offset, count);
      file.read(offset, bytes, count);
      REQUIRE(text_of(bytes) == all.substr(offset, count));
    }
  }
  file.read(7, bytes, 190'000);
  CHECK(text_of(bytes) == all.substr(7, 190'000));
  const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(static_cast<std::uint8_t>(all[i])); };
  CHECK(file.number<std::uint32_t>(65'534) ==
        (byte(65'534) | byte(65'535) << 8 | byte(65'536) << 16 | byte(65'537) << 24));
}

TEST_CASE("bag_file: a read beyond the end is damage there, and nothing is allocated for it") {
  const TemporaryDirectory directory;
  BagFile file(directory.write("bytes", "0123456789"));
  std::vector<std::uint8_t> bytes;
  CHECK((file.left_from(4) == 6 && file.left_from(10) == 0 && file.left_from(11) == 0));
  file.read(0, bytes, 10);
  CHECK(text_of(bytes) == "0123456789");
  file.read(10, bytes, 0);
  CHECK(bytes.empty());
  CHECK(damaged_at([&] { file.read(1, bytes, 10); }) == 10);
  CHECK(damaged_at([&] { file.read(11, bytes, 1); }) == 10);
  CHECK(damaged_at([&] { file.read(0, bytes, ~std::uint64_t{0}); }) == 10);
  CHECK(bytes.capacity() <= 10);
  CHECK(damaged_at([&] { file.number<std::uint64_t>(3); }) == 10);
  CHECK(file.number<std::uint8_t>(9) == '9');  // goes on
}

TEST_CASE("bag_file: an empty file has nothing, and what is no file is named") {
  const TemporaryDirectory directory;
  BagFile empty(directory.write("empty", ""));
  CHECK(empty.size() == 0);
  CHECK(damaged_at([&] { empty.number<std::uint8_t>(0); }) == 0);
  CHECK_THROWS_AS(BagFile(directory.path()), ReadError);
  const auto missing = directory.path() / "missing";
  CHECK(reports(message_of([&] { BagFile file(missing); }), missing, 0, "no such file"));
}
