"""Notes: remarks on results that are not errors."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Note:
    """A remark on a result, for programs and for people.

    code  : subject of the note, a fixed word such as "clipped" or "no-edge"
    text  : a sentence, mostly with a remedy
    where : the key, stage or file that it is about; "" for none

    JSON has these three; other files and what is printed have the text, which is also ``str(note)``.

    >>> import camsim
    >>> dark = camsim.capture("flat-field", overrides=["region={rows: 4, cols: 4}", "exposure.time_s=1e-9"])
    >>> [(note.code, note.where) for note in dark.report.notes]
    [('less-than-a-code', 'exposure.time_s')]
    """

    code: str
    text: str
    where: str = ""

    def __str__(self) -> str:
        return self.text
