"""Style of elements: attributes, style rules and inheritance."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from camsim.scene.svg.xml import Element

Refuse = Callable[[Element, str], None]

_RULE = r"([^{}]+)\{([^{}]*)\}"
_NAME = r"(?!-?\d)[\w-]+"

# Properties that affect painting, with initial values; and inherited ones.
INHERITED = {
    "fill": "black",
    "fill-rule": "nonzero",
    "fill-opacity": "1",
    "stroke": "none",
    "stroke-width": "1",
    "stroke-linecap": "butt",
    "stroke-linejoin": "miter",
    "stroke-miterlimit": "4",
    "stroke-opacity": "1",
    "stroke-dasharray": "none",
    "stroke-dashoffset": "0",
    "visibility": "visible",
    "color": "black",
    "clip-rule": "nonzero",
    "marker": "none",
    "marker-start": "none",
    "marker-mid": "none",
    "marker-end": "none",
    "paint-order": "normal",
}
OWN = {
    "opacity": "1",
    "display": "inline",
    "clip-path": "none",
    "mask": "none",
    "filter": "none",
    "mix-blend-mode": "normal",
    "vector-effect": "none",
    "transform": "",
    "transform-origin": "",
    "transform-box": "view-box",
    "overflow": "",
}
# Properties with keyword values (case-insensitive), and their values.
WORDS = {
    **dict.fromkeys(("fill-rule", "clip-rule"), ("nonzero", "evenodd")),
    "visibility": ("visible", "hidden", "collapse"),
    "display": (
        *("none", "inline", "block", "inline-block", "list-item", "flow-root", "flex", "inline-flex", "grid"),
        *("inline-grid", "table", "inline-table", "table-row-group", "table-header-group", "table-footer-group"),
        *("table-row", "table-column-group", "table-column", "table-cell", "table-caption", "compact", "marker"),
    ),
}
_IN_ANY_CASE = (*WORDS, "stroke-linecap", "stroke-linejoin", "paint-order", "overflow", "transform-box")
_AS_UNSET = ("unset", "revert", "revert-layer")
_PAINTED = ("fill", "stroke", "markers")
# Geometry in a style is refused: it belongs to attributes.
GEOMETRY = ("x", "y", "width", "height", "cx", "cy", "r", "rx", "ry", "d", "points")
# Style of position, size and visibility, and values without effect.
CHANGES = {
    **dict.fromkeys(("translate", "rotate", "scale", "offset-path", "mask-image"), ("none",)),
    **dict.fromkeys(
        (f"-webkit-{key}" for key in ("transform", "clip-path", "mask", "mask-image", "filter")), ("none",)
    ),
    "zoom": ("1", "100%", "normal"),
    "clip": ("auto",),
    "content-visibility": ("visible", "auto"),
    "all": (),
}
# Properties of a page, behind and around the drawing.
OF_PAGE = {
    **dict.fromkeys(("background", "background-color", "background-image"), ("none", "transparent")),
    **dict.fromkeys(("border", "outline", "padding"), ("none", "0", "0px")),
}
# Only the initial value of these is supported.
PLAIN = ("marker", "marker-start", "marker-mid", "marker-end", "mask", "filter", "mix-blend-mode")


@dataclass(frozen=True, slots=True)
class Rule:
    """A style rule: tag, class and id that it is for (empty: any), its properties, and those that are important."""

    tag: str
    name: str
    identity: str
    says: Mapping[str, str]
    insists: Mapping[str, str]

    @property
    def weight(self) -> int:
        """Specificity: an id outweighs classes, these outweigh tags."""
        return 100 * bool(self.identity) + 10 * bool(self.name) + bool(self.tag)

    def suits(self, element: Element) -> bool:
        """Return whether the rule matches an element."""
        return (
            self.tag in ("", element.tag)
            and self.name in ("", *element.attributes.get("class", "").split())
            and self.identity in ("", element.attributes.get("id", ""))
        )


def rules_of(root: Element, refuse: Refuse) -> list[Rule]:
    """Return the rules of all <style> elements by increasing specificity."""
    found = []
    for element in root.all():
        if element.tag != "style" or element.attributes.get("type", "text/css").strip().lower() not in ("", "text/css"):
            continue
        media = [one.strip().lower() for one in element.attributes.get("media", "all").split(",")]
        if query := next((one for one in media if not re.fullmatch(r"[a-z-]*", one)), None):
            refuse(element, f"is for media {query[:40]!r}, which is not understood; give it none, or screen")
            continue
        if not {"", "all", "screen"} & set(media):  # rules for other media do not apply
            continue
        text = re.sub(r"/\*.*?\*/", "", element.text, flags=re.DOTALL).replace("<!--", "").replace("-->", "")
        if at_rule := re.search(r"@[\w-]+", text):
            refuse(element, f"{at_rule[0]} is not understood; give fills and strokes to the elements themselves")
            continue
        if rest := re.sub(_RULE, "", text).strip():
            refuse(element, f"its rules are cut short or nested at {rest[:40]!r}; close every brace that is opened")
        for selectors, says in re.findall(_RULE, text):
            for selector in selectors.split(","):
                match = re.fullmatch(rf"(\*|[\w-]+)?(?:\.({_NAME}))?(?:#({_NAME}))?", selector.strip())
                if match is None or not selector.strip():
                    refuse(element, f"the selector {selector.strip()[:40]!r} is not understood; use a class or an id")
                    continue
                tag, name, identity = (part or "" for part in match.groups())
                found.append(Rule("" if tag == "*" else tag, name, identity, *declared(says)))
    return sorted(found, key=lambda rule: rule.weight)


def declared(text: str) -> tuple[dict[str, str], dict[str, str]]:
    """Return the properties of a style attribute or a rule's body, and those that are important.

    >>> declared("fill: red; stroke:none !important")
    ({'fill': 'red'}, {'stroke': 'none'})
    """
    says: dict[str, str] = {}
    insists: dict[str, str] = {}
    for part in re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL).split(";"):
        key, colon, value = part.partition(":")
        plain = re.sub(r"\s*!\s*important\s*$", "", value.strip(), flags=re.IGNORECASE)
        if colon and plain:  # an empty value is invalid
            (says if plain == value.strip() else insists)[key.strip().lower()] = plain
    return says, insists


def styled(element: Element, above: Mapping[str, str], rules: Sequence[Rule]) -> dict[str, str]:
    """Return an element's properties: specified, else inherited, else initial."""
    known = INHERITED | OWN
    each = {key: value.strip() for key, value in element.attributes.items() if key in known and value.strip()}
    says, insists = declared(element.attributes.get("style", ""))
    suiting = [rule for rule in rules if rule.suits(element)]
    for said in (*(rule.says for rule in suiting), says, *(rule.insists for rule in suiting), insists):
        each |= said
    found = {key: above.get(key, initial) for key, initial in INHERITED.items()} | OWN
    for key, value in each.items():
        word = value.lower()
        if key not in known:
            continue
        if word == "inherit" or (word in _AS_UNSET and key in INHERITED):
            found[key] = above.get(key, known[key])
        elif word == "initial" or word in _AS_UNSET:
            found[key] = known[key]
        else:
            found[key] = word if key in _IN_ANY_CASE or word == "none" else value
    changes = {
        key: each[key] for key, nothing in (CHANGES | OF_PAGE).items() if key in each and each[key] not in nothing
    }
    return found | {key: each[key] for key in GEOMETRY if key in each} | changes


def strange(style: Mapping[str, str]) -> dict[str, str]:
    """Return the properties with invalid keywords.

    >>> strange({"fill-rule": "odd", "visibility": "hidden", "paint-order": "stroke fill"})
    {'fill-rule': 'odd'}
    """
    found = {key: style[key] for key, words in WORDS.items() if key in style and style[key] not in words}
    order = style.get("paint-order", "normal").split()
    if order != ["normal"] and (len(set(order)) < len(order) or not {*order} <= {*_PAINTED}):
        found["paint-order"] = style["paint-order"]
    return found
