#include "plumbline/map/archive_bytes.hpp"

#include <algorithm>
#include <limits>
#include <string_view>
#include <vector>

#include "catch.hpp"

using namespace plumbline;

namespace {

/// The bytes that `write(ArchiveWriter)` writes.
std::vector<std::byte> written(const auto& write) {
  std::vector<std::byte> out;
  const auto sink = [&](std::span<const std::byte> part) { out.insert(out.end(), part.begin(), part.end()); };
  ArchiveWriter writer(sink);
  write(writer);
  CHECK(writer.checksum() == crc32(out));
  return out;
}

}  // namespace

TEST_CASE("archive_bytes: numbers are little-endian, and the checksum goes on") {
  const auto bytes = written([](auto& out) {
    out.number(std::uint32_t(0x01020304));
    out.number(1.0f);
  });
  REQUIRE(bytes.size() == 8);
  CHECK((bytes[0] == std::byte{4} && bytes[3] == std::byte{1} && bytes[6] == std::byte{0x80}));
  const std::span<const std::byte> all(bytes);
  CHECK(crc32(all.subspan(3), crc32(all.first(3))) == crc32(all));
}

TEST_CASE("archive_bytes: what is read is what was written") {
  const SO3<double> R = SO3<double>::exp({0.3, -2, 1});
  const SE3<double> T(R, {1, -2e6, 3});
  const Sim3<double> S(0.02, R, {4, 5, -6});
  Mat<double, 6, 6> A = zeros<double, 6, 6>();
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) A(i, j) = 1.0 / (1 + i + j);
  const auto bytes = written([&](auto& out) {
    out.text(std::string_view("map"));
    out.number(std::int64_t(-5));
    out.pose(T);
    out.similarity(S);
    out.symmetric(A);
  });
  ArchiveReader in(bytes);
  CHECK(in.text(std::string_view("map")));
  CHECK(in.time() == -5);
  CHECK(in.pose().p() == T.p());
  const Sim3<double> read = in.similarity();
  CHECK((read.scale() == 0.02 && read.t() == S.t() && (read.rotation().inverse() * R).log().norm() < 1e-12));
  CHECK(in.symmetric<6>() == A);
  CHECK((in.is_good() && in.left() == 0));
  (void)in.real32();
  CHECK_FALSE(in.is_good());
}

TEST_CASE("archive_bytes: numbers that are none, or so large that float has no square of them, are refused") {
  constexpr double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  for (const double x : {nan, inf, -inf, 1.1e12, -1.1e12, 1e300}) {
    CAPTURE(x);
    const auto wide = written([&](auto& out) { out.number(x); });
    ArchiveReader in(wide);
    (void)in.real64();
    CHECK_FALSE(in.is_good());
    const auto narrow = written([&](auto& out) { out.number(static_cast<float>(std::min(x, 1e38))); });
    ArchiveReader short_in(narrow);
    (void)short_in.real32();
    CHECK_FALSE(short_in.is_good());
  }
  const auto bytes = written([](auto& out) { out.number(1e12); });
  ArchiveReader in(bytes);
  CHECK((in.real64() == 1e12 && in.is_good()));
}

TEST_CASE("archive_bytes: a scale that is read can be saved again in float and in double; a rotation has unit length") {
  for (const double scale : {-1.0, 0.0, 1e-9, 1.0000000001e-9, 2e-9, 1.0, 9e8, 9.9999999999e8, 1e9}) {
    CAPTURE(scale);
    const auto bytes = written([&](auto& out) { out.similarity(Sim3<double>(scale, {}, {0, 0, 0})); });
    ArchiveReader in(bytes);
    const double read = in.similarity().scale();
    if (!in.is_good()) continue;
    const auto again = written([&](auto& out) { out.similarity(Sim3<double>(double(float(read)), {}, {0, 0, 0})); });
    ArchiveReader in_again(again);
    CHECK(in_again.similarity().scale() == Approx(scale));
    CHECK(in_again.is_good());
  }
  for (const double scale : {2e-9, 1.0, 9e8}) {
    const auto bytes = written([&](auto& out) { out.similarity(Sim3<double>(scale, {}, {0, 0, 0})); });
    ArchiveReader in(bytes);
    CHECK(in.similarity().scale() == scale);
    CHECK(in.is_good());
  }
  const auto bytes = written([](auto& out) {
    for (const double x : {0.5, 0.5, 0.5, 0.6}) out.number(x);
  });
  ArchiveReader in(bytes);
  (void)in.rotation();
  CHECK_FALSE(in.is_good());
}
