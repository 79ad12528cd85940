#include "runner.hpp"

#include <stdexcept>

#include "nearest.hpp"

const Configuration& configuration_named(const std::string& name) {
  std::vector<std::string> known;
  for (const Configuration& configuration : configurations()) {
    if (name == configuration.name) return configuration;
    known.push_back(configuration.name);
  }
  throw std::runtime_error(unknown_name("configuration", name, known));
}
