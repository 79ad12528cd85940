#include "marks.hpp"

#include <unordered_map>
#include <unordered_set>

std::vector<Mark> marks_of(const FeatureInspection* before, const FeatureInspection& now, bool was_of_use) {
  std::unordered_map<std::uint32_t, Sighting> previous;
  if (before != nullptr)
    for (const Sighting& seen : before->seen) previous.emplace(seen.id, seen);

  std::vector<Mark> marks;
  std::unordered_set<std::uint32_t> known;
  const auto add = [&](MarkState state, const Sighting& seen) {
    if (!known.insert(seen.id).second) return;
    const auto found = previous.find(seen.id);
    Mark mark{state, now.are_lines, seen, std::nullopt};
    if (found != previous.end()) mark.before = found->second;
    const bool put_back = mark.before && mark.before->start == seen.start && mark.before->end == seen.end;
    if (put_back && !was_of_use) mark.state = MarkState::lost;
    if (mark.state == MarkState::lost) mark.before.reset();
    marks.push_back(mark);
  };
  for (const Sighting& seen : now.seen) add(seen.located ? MarkState::located : MarkState::unlocated, seen);
  for (auto seen = now.rejected.rbegin(); seen != now.rejected.rend(); ++seen) add(MarkState::rejected, *seen);
  if (before != nullptr)
    for (const Sighting& seen : before->seen) add(MarkState::lost, seen);
  return marks;
}

std::array<int, mark_states> count_states(const std::vector<Mark>& marks) {
  std::array<int, mark_states> counts{};
  for (const Mark& mark : marks) ++counts[static_cast<std::size_t>(mark.state)];
  return counts;
}
