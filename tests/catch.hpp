#pragma once
// Catch2 is version 2 on Debian 12 and version 3 elsewhere; the tests use what both have.
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
using Catch::Approx;
#else
#include <catch2/catch.hpp>
#endif
#include <string>

/// Whether that file or folder of the recordings is missing, which it prints. A test case that needs it has the tag
/// [data] and begins with `if (skip_without(path)) return;`. A program that skipped a case and failed none returns
/// `skipped_return_code`, which ctest reports as skipped.
bool skip_without(const std::string& path);
inline constexpr int skipped_return_code = 77;
