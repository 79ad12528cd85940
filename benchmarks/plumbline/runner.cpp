#include "runner.hpp"

#include <algorithm>
#include <stdexcept>
#include <string_view>

#include "misuse.hpp"
#include "nearest.hpp"

const Configuration& configuration_named(const std::string& name) {
  std::vector<std::string> known;
  for (const Configuration& configuration : configurations()) {
    if (name == configuration.name) return configuration;
    known.push_back(configuration.name);
  }
  throw Misuse(unknown_name("configuration", name, known));
}

const Configuration& recommended_for(const Needs& there) {
  const auto rank = [&](const Configuration& configuration) {
    const auto& [name, needs, make] = configuration;
    if ((needs.depth && !there.depth) || (needs.imu && !there.imu)) return -1;
    const std::string_view full = name, kind = full.substr(std::min(full.find('/'), full.size()));
    const int sensors = 2 * needs.depth + 2 * needs.imu;
    const int features = kind.starts_with("/points+lines/") ? 2 : kind.starts_with("/points/") ? 1 : 0;
    return 100 * sensors + 10 * features + kind.ends_with("/window");
  };
  const auto best = std::max_element(configurations().begin(), configurations().end(),
                                     [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  if (best == configurations().end() || rank(*best) < 0)
    throw std::runtime_error("this program was built without a configuration for a recording like this: see list");
  return *best;
}
