"""What ``make docs`` asks of the finished site: python docs/_ext/judge.py out/site

Every link leads somewhere, nothing is fetched from a network, every page is at most three clicks from the first, and
the search index has the words that people look for.
"""

from __future__ import annotations

import json
import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urldefrag

MOST_CLICKS = 3
WORDS = ("demosaic", "lp/mm", "black level", "OLPF split", "Zernike", "sweep")
_FETCHED = {"script": "src", "link": "href", "img": "src", "iframe": "src", "source": "src"}


class Page(HTMLParser):
    """A page's links, what it loads, and the places in it that links can name."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.fetched: list[str] = []
        self.places: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        said = dict(attrs)
        if said.get("id"):
            self.places.add(said["id"] or "")
        if tag == "a" and said.get("href"):
            self.links.append(said["href"] or "")
        if tag in _FETCHED and said.get(_FETCHED[tag]) and said.get("rel") != "canonical":
            self.fetched.append(said[_FETCHED[tag]] or "")


def pages_of(site: Path) -> dict[Path, Page]:
    """Return the pages of a site."""
    found = (path for path in sorted(site.rglob("*.html")) if "_static" not in path.parts)
    return {path.resolve(): Page(path.read_text(encoding="utf-8")) for path in found}


def faults_of_links(pages: dict[Path, Page]) -> list[str]:
    """Return what leads nowhere, and what would be fetched from a network."""
    faults = []
    for path, page in pages.items():
        for link in [*page.links, *page.fetched]:
            if re.match(r"(https?:)?//", link) and link in page.fetched:
                faults.append(f"{path.name}: loads {link}")
            if re.match(r"[a-z]+:|//", link):
                continue
            place, fragment = urldefrag(link)
            target = (path.parent / unquote(place.split("?")[0])).resolve() if place else path
            if not target.exists():
                faults.append(f"{path.name}: {link} leads nowhere")
            elif fragment and target in pages and unquote(fragment) not in pages[target].places:
                faults.append(f"{path.name}: {link}: there is no such place")
    return faults


def clicks_from(first: Path, pages: dict[Path, Page]) -> dict[Path, int]:
    """Return how many clicks each page is from the first."""
    clicks = {first.resolve(): 0}
    front = list(clicks)
    while front:
        path = front.pop(0)
        for link in pages[path].links:
            target = (path.parent / unquote(urldefrag(link)[0].split("?")[0])).resolve()
            if target in pages and target not in clicks:
                clicks[target] = clicks[path] + 1
                front.append(target)
    return clicks


def words_missing(site: Path) -> list[str]:
    """Return the words that no page is found by; stems are Porter's, so a word's beginning will do."""
    index = (site / "searchindex.js").read_text(encoding="utf-8")
    terms = json.loads(re.search(r"Search\.setIndex\((.*)\)", index, re.DOTALL)[1])  # type: ignore[index]
    known = {*terms["terms"], *terms["titleterms"]}
    parts = {words: re.findall(r"\w+", words.lower()) for words in WORDS}
    return [words for words, each in parts.items() if not all(any(k.startswith(w[:5]) for k in known) for w in each)]


def main() -> None:
    """Print what is wrong, and exit with 1 if anything is."""
    site = Path(sys.argv[1])
    pages = pages_of(site)
    clicks = clicks_from(site / "index.html", pages)
    own = {path for path in pages if path.name not in ("search.html", "genindex.html", "py-modindex.html")}
    faults = faults_of_links(pages)
    faults += [f"{path.name}: is not reached from the first page" for path in own - set(clicks)]
    faults += [f"{path.name}: is {n} clicks away" for path, n in clicks.items() if n > MOST_CLICKS]
    faults += [f"search: nothing for {words!r}" for words in words_missing(site)]
    print("\n".join(faults) or f"{len(pages)} pages, no dead link, all within {max(clicks.values())} clicks")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
