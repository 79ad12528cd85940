#include "plumbline/io/output_file.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "../temporary_directory.hpp"
#include "catch.hpp"

using plumbline::io::OutputFile;

namespace {

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

TEST_CASE("output_file: appears when it is complete, in place of what was there") {
  const TemporaryDirectory directory;
  const auto file = directory.write("out.txt", "old");
  OutputFile out(file);
  out.stream() << "new\n";
  out.stream().flush();
  REQUIRE(text_of(file) == "old");
  out.commit();
  REQUIRE(text_of(file) == "new\n");
  REQUIRE(!std::filesystem::exists(file.string() + ".part"));
}

TEST_CASE("output_file: without commit nothing is left") {
  const TemporaryDirectory directory;
  { OutputFile(directory.path() / "out.txt").stream() << "half"; }
  REQUIRE(std::filesystem::is_empty(directory.path()));
}

TEST_CASE("output_file: an existing file of the same name with .part is kept") {
  const TemporaryDirectory directory;
  const auto file = directory.path() / "out.txt", mine = directory.write("out.txt.part", "mine");
  { OutputFile(file).stream() << "half"; }
  REQUIRE(text_of(mine) == "mine");
  OutputFile out(file);
  out.stream() << "whole";
  out.commit();
  REQUIRE((text_of(file) == "whole" && text_of(mine) == "mine"));
  REQUIRE(std::distance(std::filesystem::directory_iterator(directory.path()), {}) == 2);
}

TEST_CASE("output_file: complete, but not yet under its name") {
  const TemporaryDirectory directory;
  const auto file = directory.path() / "out.txt";
  {
    OutputFile out(file);
    out.stream() << "whole";
    out.complete();
    REQUIRE(!std::filesystem::exists(file));
  }
  REQUIRE(std::filesystem::is_empty(directory.path()));
}

TEST_CASE("output_file: no name") {
  REQUIRE(message_of([] { OutputFile{""}; }) == "an output has an empty name");
}

TEST_CASE("output_file: what cannot be written is named") {
  const TemporaryDirectory directory;
  const auto missing = directory.path() / "missing" / "out.txt";
  REQUIRE(reports(message_of([&] { OutputFile{missing}; }), missing, 0, "cannot be written"));
  REQUIRE(reports(message_of([&] { OutputFile{directory.path()}; }), directory.path(), 0, "is a directory"));
}

TEST_CASE("output_file: a symbolic link is kept, and its target is written") {
  const TemporaryDirectory directory;
  const auto file = directory.write("out.txt", "old"), link = directory.path() / "link.txt";
  std::filesystem::create_symlink(file, link);
  OutputFile out(link);
  out.stream() << "new";
  out.commit();
  REQUIRE(std::filesystem::is_symlink(link));
  REQUIRE(text_of(file) == "new");
}

TEST_CASE("output_file: a device stays one") {
  const std::filesystem::path device = "/dev/full";  // takes nothing
  if (!std::filesystem::is_character_file(device)) return;
  OutputFile out(device);
  out.stream() << "lost";
  REQUIRE(reports(message_of([&] { out.complete(); }), device, 0, "disk full"));
  REQUIRE(reports(message_of([&] { out.commit(); }), device, 0, "disk full"));
  REQUIRE(std::filesystem::is_character_file(device));
}
