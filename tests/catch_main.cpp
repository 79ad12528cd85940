#if __has_include(<catch2/catch_session.hpp>)
#include <catch2/catch_session.hpp>
#else
#define CATCH_CONFIG_RUNNER
#endif
#include <filesystem>
#include <iostream>

#include "catch.hpp"

namespace {

bool has_skipped = false;

}  // namespace

bool skip_without(const std::string& path) {
  if (std::filesystem::exists(path)) return false;
  std::cout << "skipped: no recordings at " << path << std::endl;
  has_skipped = true;
  return true;
}

int main(int argc, char* argv[]) {
  const int result = Catch::Session().run(argc, argv);
  return result == 0 && has_skipped ? skipped_return_code : result;
}
