"""Input filter of doxygen: writes a header with its `///` comments as doxygen reads them, line for line.

The comments are Markdown with formulas. Lines indented by two spaces or more are formulas or tables and become verbatim
text; the first comment of a header is that of the file; special characters of doxygen outside of backticks are escaped;
`docs/*.md` becomes a link to that page. The type that a header is named after takes the comment of the header where it
has none of its own.
"""
import os
import re
import sys

SPECIAL = re.compile(r"([\\@<>#&%])")
PAGE = re.compile(r"\bdocs/((?:[\w-]+/)*[\w-]+)\.md\b")
WORD = re.compile(r"(?<![\w%.:<])([A-Z][a-z]+)\b(?![<:(])")  # of English, though there may be a type of that name
LIST_ITEM = re.compile(r"(?:[-+*]|\d+\.) ")


def escape(text):
    text = WORD.sub(r"%\1", SPECIAL.sub(r"\\\1", text))
    return PAGE.sub(r"[docs/\1.md](../\1.html)", text)


def prose(lines):
    """The lines of one block of prose, escaped; spans of code may go from one line to the next."""
    parts = re.split(r"(`[^`]*`)", "\n".join(lines))
    for i, part in enumerate(parts):
        if i % 2 == 0:
            parts[i] = escape(part)
        elif "'" in part:  # doxygen reads it as the end of a quotation
            parts[i] = "<code>" + SPECIAL.sub(r"\\\1", part[1:-1]) + "</code>"
    return "".join(parts).split("\n")


def convert(texts, is_file):
    """One comment, given without its slashes, as lines of a comment that begins with /** and ends with */."""
    out = []
    block = []
    verbatim = False
    in_list = False

    def close_prose():
        out.extend(prose(block))
        block.clear()

    for text in texts:
        text = text.strip() if PAGE.match(text.strip()) else text.removeprefix(" ")
        if LIST_ITEM.match(text):
            in_list = True
        elif text and not text.startswith("  "):
            in_list = False
        is_formula = text.startswith("  ") and not in_list
        if is_formula and not verbatim:
            if block:
                close_prose()
                out[-1] += " @verbatim"
            else:
                text = "@verbatim " + text
            verbatim = True
        elif verbatim and not is_formula:
            out[-1] += " @endverbatim"
            verbatim = False
        if verbatim:
            out.append(text)
        else:
            block.append(text)
    if block:
        close_prose()
    if verbatim:
        out[-1] += " @endverbatim"
    out[0] = ("/** @file\n" if is_file else "/** ") + out[0]
    out[-1] += " */"
    return out


def is_named_after(name, stem):
    return ("_" + re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()).endswith("_" + stem)


def describe_type(lines, path):
    """Puts a reference to the comment of the file before the type of its name, in place of an empty line."""
    stem = os.path.splitext(os.path.basename(path))[0]
    for i, line in enumerate(lines):
        type_name = re.match(r"(?:struct|class|concept) (\w+)(?!.*;$)", line)
        if not type_name or not is_named_after(type_name[1], stem):
            continue
        first = i
        while first > 0 and re.match(r"(?:template <|  requires)", lines[first - 1]):
            first -= 1
        if first > 0 and lines[first - 1] == "":
            lines[first - 1] = "/** @copydoc " + os.path.relpath(path, "include") + " */"
        return


def main(path):
    with open(path, encoding="utf-8") as file:
        lines = file.read().split("\n")
    out = []
    i = 0
    while i < len(lines):
        line = lines[i]
        comment = re.match(r"(\s*)///(?!<)(.*)", line)
        trailing = re.match(r"(.*?)///<(.*)", line)
        if line.strip() == "#pragma once" and i + 1 < len(lines) and lines[i + 1].startswith("///"):
            texts = []
            for j in range(i + 1, len(lines)):
                if not lines[j].startswith("///"):
                    break
                texts.append(lines[j][3:])
            out += "\n".join(convert(texts, True)).split("\n")
            i += 1 + len(texts)
        elif comment:
            texts = []
            while i < len(lines) and re.match(r"\s*///(?!<)", lines[i]):
                texts.append(lines[i].split("///", 1)[1])
                i += 1
            out += convert(texts, False)
        elif trailing:
            texts = [trailing[2]]
            code = trailing[1]
            i += 1
            while i < len(lines) and re.match(r"\s*///<", lines[i]):
                texts.append(lines[i].split("///<", 1)[1])
                i += 1
            texts = prose([text.strip() for text in texts])
            out.append(code + "/**< " + texts[0] + ("" if len(texts) > 1 else " */"))
            out += texts[1:-1]
            if len(texts) > 1:
                out.append(texts[-1] + " */")
        else:
            out.append(line)
            i += 1
    if "/** @file" in out:
        describe_type(out, path)
    sys.stdout.write("\n".join(out))


main(sys.argv[1])
