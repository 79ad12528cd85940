#pragma once
/// What can be known of a recording before the run: do the clocks agree, are the units those that are expected, is
/// there something to see? Looks at every time stamp and reading, and at a few images.            docs/datasets.md

#include <string>
#include <vector>

#include "plumbline/io/recording.hpp"
#include "runner.hpp"

struct Finding {
  bool is_error;     ///< a run cannot work; else it is odd
  std::string text;  ///< one line: file, what was found, what is expected, and what was probably meant
};

/// Of all that a configuration with these needs will use; empty where nothing is odd.
std::vector<Finding> check_recording(const plumbline::io::Recording& recording, const Needs& needs);

/// The parts of it.
std::vector<Finding> check_clocks(const plumbline::io::Recording& recording, const Needs& needs);
std::vector<Finding> check_readings(const plumbline::io::Recording& recording);
std::vector<Finding> check_images(const plumbline::io::Recording& recording, const Needs& needs);
