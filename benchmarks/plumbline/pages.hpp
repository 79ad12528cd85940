#pragma once
/// The files of benchmarks/report/dist; CMake makes the source from pages.cpp.in.

#include <string_view>

/// Empty when there is none of that name.
std::string_view page_named(std::string_view name);
