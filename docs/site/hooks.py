"""What mkdocs does beyond its configuration.

- The records of docs/decisions follow their index in the navigation, and pages of docs/math that mkdocs.yml does not
  list follow the others. Any other page that is in no section is an error.
- Links from pages to files outside of docs/, by path or by address of the repository, lead to the API reference
  (headers) or to a page with the file's text.
- The API reference of doxygen and the scripts of docs/build.sh ($PLUMBLINE_SITE_PARTS) are part of the site.
- A list needs no empty line before it, as on GitHub.
- The search index is also written as a script: a page that is opened from the disk may not fetch files.
"""
import json
import logging
import os
import posixpath
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from mkdocs.structure.files import File

log = logging.getLogger("mkdocs.plumbline")  # warnings of mkdocs.* fail a strict build
top = Path(__file__).resolve().parents[2]
parts = Path(os.environ["PLUMBLINE_SITE_PARTS"])
not_pages = re.compile(r"site/|Doxyfile$|.*\.sh$|(?:.*/)?README\.md$|(?:.*/)?templates/")
link = re.compile(r"(?:\]\(|^\[[^]]+\]: +|^ +(?=https://))([^)\s#]+)")  # in a line, or defined at the end of a page
repository = "https://github.com/plumbline/plumbline/"
fence = re.compile(r"\s*(```|~~~)")
list_item = re.compile(r"([-*+]|1\.) ")
languages = {".cpp": "cpp", ".hpp": "cpp", ".sh": "bash", ".py": "python", ".json": "json", ".cmake": "cmake",
             ".yaml": "yaml", ".yml": "yaml", ".txt": "text", "": "text"}


def pages_of(folder, pattern):
    return sorted(f"{folder}/{path.name}" for path in (top / "docs" / folder).glob(pattern))


def title_of(path):
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("# "):
            return line[2:].replace("`", "")
    log.warning("%s has no title", path)
    return path.stem


def on_config(config):
    listed = re.findall(r"[\w/-]+\.md", str(config["nav"]))
    for section in config["nav"]:
        for name, pages in section.items():
            added = {"Decisions": pages_of("decisions", "[0-9]*.md"), "Mathematics": pages_of("math", "*.md")}
            for page in added.get(name, []):
                if page not in listed:
                    pages.append({title_of(top / "docs" / page): page})
    return config


def links_to_files(lines):
    """(number of the line, match) of each link of a page to a file, but for those in blocks of code."""
    is_code = False
    for number, line in enumerate(lines):
        if fence.match(line):
            is_code = not is_code
        if is_code or (line.startswith("    ") and (number == 0 or not lines[number - 1].strip())):
            continue
        for match in link.finditer(re.sub(r"`[^`]*`", lambda code: "`" + " " * (len(code[0]) - 2) + "`", line)):
            if match[1].startswith(repository) or not re.match(r"[a-z]+:|/", match[1]):
                yield number, match


def target_of(page, path):
    """The file that a link of a page of docs/ leads to, relative to the top folder."""
    if path.startswith(repository):
        return posixpath.normpath(re.sub(r"^(blob|tree)/main/", "", path[len(repository):]))
    return posixpath.normpath(posixpath.join("docs", posixpath.dirname(page), path))


def header_pages():
    """The pages of the API reference by header and folder."""
    pages = {}
    for compound in ElementTree.parse(parts / "tags.xml").iter("compound"):
        if compound.get("kind") in ("file", "dir"):
            name = compound.findtext("name") if compound.get("kind") == "file" else ""
            path = os.path.relpath(os.path.join(compound.findtext("path"), name), top)
            pages[path] = "api/" + compound.findtext("filename")
    return pages


def add_source(path, config):
    """A page with the text of a file, or with the list of a folder."""
    source = top / path
    page = f"source/{path}.md" if source.suffix != ".md" else f"source/{path}"
    if source.is_dir():
        text = f"# `{path}`\n\n" + "\n".join(f"- `{entry.name}`" for entry in sorted(source.iterdir())) + "\n"
    elif source.suffix == ".md":
        text = "\n".join([f"# `{path}`", "", "````text", source.read_text(encoding="utf-8").rstrip("\n"), "````", ""])
    else:
        language = languages.get(source.suffix, "text")
        text = f"# `{path}`\n\n````{language}\n" + source.read_text(encoding="utf-8").rstrip("\n") + "\n````\n"
    written = parts / "pages" / page
    written.parent.mkdir(parents=True, exist_ok=True)
    written.write_text(text, encoding="utf-8")
    return File(page, str(parts / "pages"), config["site_dir"], config["use_directory_urls"])


def on_files(files, config):
    for file in list(files):
        if not_pages.match(file.src_uri):
            files.remove(file)
    for folder in ("api", "assets"):
        for path in sorted((parts / folder).rglob("*")):
            if path.is_file():
                files.append(File(str(path.relative_to(parts)), str(parts), config["site_dir"],
                                  config["use_directory_urls"]))
    config["outside"] = header_pages()
    for file in list(files.documentation_pages()):
        for _, match in links_to_files(Path(file.abs_src_path).read_text(encoding="utf-8").splitlines()):
            path = target_of(file.src_uri, match[1])
            is_page = path.startswith("docs/") and not not_pages.match(path[5:])  # mkdocs looks whether it is there
            if is_page or path in config["outside"]:
                continue
            if path.startswith("../") or not (top / path).exists():
                log.warning("%s: no file is at the end of the link to %s", file.src_uri, match[1])
                continue
            added = add_source(path, config)
            files.append(added)
            config["outside"][path] = added.src_uri
    return files


def on_nav(nav, config, files):
    shown = {page.file.src_uri for page in nav.pages}
    for file in files.documentation_pages():
        if file.src_uri not in shown and not file.src_uri.startswith("source/"):
            log.warning("%s is in no section of mkdocs.yml", file.src_uri)
    return nav


def on_page_markdown(markdown, page, config, files):
    if page.file.src_uri.startswith("source/"):
        return markdown
    lines = markdown.split("\n")
    for number, match in reversed(list(links_to_files(lines))):
        outside = config["outside"].get(target_of(page.file.src_uri, match[1]))
        if outside:
            line = lines[number]
            path = posixpath.relpath(outside, posixpath.dirname(page.file.src_uri) or ".")
            lines[number] = line[:match.start(1)] + path + line[match.end(1):]
    out = []
    is_code = False
    for line in lines:
        if fence.match(line):
            is_code = not is_code
        in_list = bool(out) and (list_item.match(out[-1].lstrip()) or out[-1].startswith(" "))
        if not is_code and list_item.match(line) and out and out[-1].strip() and not in_list:
            out.append("")
        out.append(line)
    return "\n".join(out)


def on_post_build(config):
    site = Path(config["site_dir"])
    index = json.loads((site / "search/search_index.json").read_text(encoding="utf-8"))
    index["docs"] = [doc for doc in index["docs"] if not doc["location"].startswith("source/")]
    text = json.dumps(index, ensure_ascii=False, separators=(",", ":"))
    (site / "search/search_index.json").write_text(text, encoding="utf-8")
    script = f"var __search = {{index: Promise.resolve({text})}};\n"
    (site / "search/search_index.js").write_text(script, encoding="utf-8")
