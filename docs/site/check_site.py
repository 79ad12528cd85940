"""Checks a built site: links and anchors lead somewhere, nothing is loaded from a network, diagrams are drawn.

usage: check_site.py FOLDER
"""
import os
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

site = Path(sys.argv[1]).resolve()
errors = []


class Page(HTMLParser):
    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.ids, self.links, self.loaded = set(), [], []
        self.has_diagram = '<pre class="diagram"' in text
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.ids.update(value for value in (attrs.get("id"), attrs.get("name")) if value)
        if tag == "a" and attrs.get("href"):
            self.links.append(attrs["href"])
        elif tag in ("link", "script", "img", "source", "iframe", "object"):
            url = attrs.get("src") or attrs.get("href") or attrs.get("data")
            if url and attrs.get("rel") != "canonical":
                self.loaded.append(url)


pages = {path: Page(path.read_text(encoding="utf-8")) for path in sorted(site.rglob("*.html"))}


def check(page, url, is_loaded):
    parts = urlsplit(url)
    where = page.relative_to(site)
    if parts.scheme in ("data", "javascript", "mailto"):
        return
    if parts.scheme or parts.netloc:
        if is_loaded:
            errors.append(f"{where}: loads {url} from a network")
        return
    target = page
    if parts.path:
        root = site if parts.path.startswith("/") else page.parent
        target = Path(os.path.normpath(root / unquote(parts.path).lstrip("/")))
    if target.is_dir():
        target = target / "index.html"
    if not target.exists():
        errors.append(f"{where}: nothing is at {url}")
    elif where.parts[0] == "api":  # doxygen refers to hidden friends, which it does not show
        return
    elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].ids:
        errors.append(f"{where}: no anchor {url}")


def check_diagrams(path, chromium):
    """diagrams.js replaces <pre class="diagram"> by the drawing; where the diagram has an error, it stays."""
    command = [chromium, "--headless", "--no-sandbox", "--disable-gpu", "--host-resolver-rules=MAP * ~NOTFOUND",
               "--virtual-time-budget=20000", "--dump-dom", path.as_uri()]
    dom = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True).stdout
    if '<pre class="diagram"' in dom or '<div class="diagram"' not in dom:
        errors.append(f"{path.relative_to(site)}: a diagram is not drawn")


for path, page in pages.items():
    for url in page.links:
        check(path, url, False)
    for url in page.loaded:
        check(path, url, True)
browser = os.environ.get("CHROMIUM") or shutil.which("chromium")
for path, page in pages.items():
    if page.has_diagram and browser:
        check_diagrams(path, browser)

if errors:
    sys.exit("\n".join(errors))
print(f"{len(pages)} pages, all links lead somewhere")
