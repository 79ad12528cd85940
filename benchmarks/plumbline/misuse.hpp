#pragma once
/// The error of a command line: an option or a name that there is not, or options that do not go together. The exit
/// status is 2; that of files which cannot be used, and of work that fails, is 1.

#include <stdexcept>

class Misuse : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
