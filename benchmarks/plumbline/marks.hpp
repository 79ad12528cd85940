#pragma once
/// What became of each feature from one frame to the next.

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "inspection.hpp"

enum class MarkState : std::size_t { located, unlocated, rejected, lost };
inline constexpr std::size_t mark_states = 4;
inline constexpr std::array mark_state_names{"located", "unlocated", "rejected", "lost"};

struct Mark {
  MarkState state;
  bool is_line;
  Sighting now;                    ///< of what is lost: where it was seen last
  std::optional<Sighting> before;  ///< in the frame before; none of what is new, found again or lost
};

/// The marks of one kind of features; `before` is the kind in the frame before, nullptr if there was none. A frame that
/// was of no use puts back what was seen before it: all of that is lost there, `was_of_use` is false.
std::vector<Mark> marks_of(const FeatureInspection* before, const FeatureInspection& now, bool was_of_use);

/// How many are in each state.
std::array<int, mark_states> count_states(const std::vector<Mark>& marks);
