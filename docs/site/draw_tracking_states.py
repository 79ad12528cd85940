"""Draws the transition table of include/plumbline/state/tracking_state.hpp into docs/concepts/tracking_state.md.

--check: fails where another drawing stands there.
"""
import re
import sys
from pathlib import Path

root = Path(__file__).resolve().parents[2]
header = (root / "include/plumbline/state/tracking_state.hpp").read_text(encoding="utf-8")
page = root / "docs/concepts/tracking_state.md"
begin, end = "<!-- drawn by docs/build.sh -->\n", "<!-- end of drawing -->\n"


def enumerators(name):
    body = re.search(rf"enum class {name} : std::uint8_t \{{(.*?)\n\}};", header, re.S)[1]
    return re.findall(r"^\s*(\w+),\s*///< (.*)$", body, re.M)


states, events = enumerators("TrackingState"), enumerators("TrackingEvent")
table = re.search(r"return std::array<Row, tracking_states>\{\{(.*?)\}\};", header, re.S)[1]
table = re.sub(r"//[^\n]*", "", table)
rows = re.findall(r"/\* (\w+) \*/\s*\{(.*?)\}", table, re.S)
rows = [(state, re.findall(r"\w+", row)) for state, row in rows]
if [state for state, _ in rows] != [name for name, _ in states] or any(len(row) != len(events) for _, row in rows):
    sys.exit("tracking_state.hpp: the table is not that of its states and events")

edges = {}
for state, row in rows:
    for (event, _), target in zip(events, row):
        if target != state:
            edges.setdefault((state, target), []).append(event.replace("_", " "))
text = begin + "\n```mermaid\nstateDiagram-v2\n  [*] --> uninitialized\n"
for (state, target), names in edges.items():
    text += f"  {state} --> {target}: {', '.join(names)}\n"
text += "```\n\n| state | meaning |\n| --- | --- |\n"
text += "".join(f"| `{name}` | {meaning} |\n" for name, meaning in states)
text += "\n| event | meaning |\n| --- | --- |\n"
text += "".join(f"| `{name}` | {meaning} |\n" for name, meaning in events)
text += "\n| event | " + " | ".join(f"in `{name}`" for name, _ in states) + " |\n"
text += "| --- " * (len(states) + 1) + "|\n"
for k, (event, _) in enumerate(events):
    cells = ["" if row[k] == state else f"`{row[k]}`" for state, row in rows]
    text += f"| `{event}` | " + " | ".join(cells) + " |\n"
text += "\n" + end

old = page.read_text(encoding="utf-8")
new = old[: old.index(begin)] + text + old[old.index(end) + len(end) :]
if new != old:
    if "--check" in sys.argv:
        sys.exit(f"{page} does not show the transitions; run docs/build.sh")
    page.write_text(new, encoding="utf-8")
