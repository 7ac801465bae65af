"""Pages that stand where their readers look for them, outside docs/, and are part of the site all the same.

A page of docs/ that is nothing but one link to such a file becomes that file; its links
are turned to the site's pages.
"""

import re
from pathlib import Path

DOCS = Path(__file__).resolve().parent.parent
_ONLY_A_LINK = re.compile(r"\A\[[^\]]*\]\(([^)]+\.md)\)\s*\Z")
_LINK = re.compile(r"(\]\()([^)#:\s]+)([^)]*\))")


def _elsewhere():
    """Path of each file outside -> the page that it becomes."""
    found = {}
    for page in sorted(DOCS.glob("*.md")):
        link = _ONLY_A_LINK.match(page.read_text(encoding="utf-8"))
        if link:
            found[(DOCS / link[1]).resolve()] = page.name
    return found


def page_of(name):
    """The text that the page docs/NAME.md is on the site, or None when it is that of the file itself."""
    files = {page: path for path, page in _elsewhere().items()}
    path = files.get(name + ".md")
    if path is None:
        return None

    def turned(link):
        target = (path.parent / link[2]).resolve()
        if target in _elsewhere():
            return link[1] + _elsewhere()[target] + link[3]
        if target.is_relative_to(DOCS):
            return link[1] + str(target.relative_to(DOCS)) + link[3]
        return link[0]

    return _LINK.sub(turned, path.read_text(encoding="utf-8"))


def _read(app, name, source):
    """Sphinx's event source-read."""
    text = page_of(name)
    if text is not None:
        source[0] = text


def setup(app):
    app.connect("source-read", _read)
    return {"parallel_read_safe": True}
