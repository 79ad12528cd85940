"""Writes the list of records into docs/decisions/index.md.

--check: fails where another list is written there.
"""
import re
import sys
from pathlib import Path

folder = Path(__file__).resolve().parents[1] / "decisions"
index = folder / "index.md"
marker = "<!-- The list below is written by docs/build.sh. -->\n"

rows = []
for path in sorted(folder.glob("[0-9]*.md")):
    title = re.match(r"# (\d+) (.+)", path.read_text(encoding="utf-8"))
    if not title or not path.name.startswith(title[1]):
        sys.exit(f"{path}: the first line is not '# NUMBER TITLE' with the number of the file's name")
    rows.append(f"| {title[1]} | [{title[2]}]({path.name}) |\n")

old = index.read_text(encoding="utf-8")
head = old.split(marker)[0]
new = head + marker + "\n| Record | Decision |\n| --- | --- |\n" + "".join(rows)
if new != old:
    if "--check" in sys.argv:
        sys.exit(f"{index} does not list the records; run docs/build.sh")
    index.write_text(new, encoding="utf-8")
