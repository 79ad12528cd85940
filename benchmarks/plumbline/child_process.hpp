#pragma once
/// Jobs in separate processes, in parallel: a crash or a hang affects its own process only.

#include <cstddef>
#include <functional>
#include <string>

struct ChildLimits {
  std::size_t side_by_side = 1;
  double seconds = 600;  ///< of each
};

/// Calls work(0) ... work(count - 1), each in a child process, and in this one `ended(index, failure)` after each:
/// nothing, or in one line why it failed. False when SIGINT or SIGTERM came: the children are stopped then.
bool run_in_children(std::size_t count, const ChildLimits& limits, const std::function<void(std::size_t)>& work,
                     const std::function<void(std::size_t, const std::string&)>& ended);
