"""Mutants that were judged equivalent: no test can tell them from the source. Kept in random_equivalents.json, each with the
reason and without line numbers:

    {"file": "db/record.cpp", "line": "the text of the line", "change": "< -> <=", "nth": 1, "reason": "why nothing changes"}

`nth` counts the like changes of the line from 1 and may be left out. An entry that fits no place of its file, or several, is
an error: the source has changed, and the judgement with it.
"""
import json

from .changes import changes_of, line_of, shown

KEYS = {"file", "line", "change", "reason"}


class Wrong(Exception):
    """An entry of the file that cannot be used; says which and why."""


def reasons(path, text_of):
    """Id of the change -> reason, for all entries of the file. `text_of(source)` gives a source's text."""
    found = {}
    for entry in json.loads(path.read_text("utf-8")):
        what = f"{path.name}: {json.dumps(entry, ensure_ascii=False)}"
        if not KEYS <= entry.keys() <= KEYS | {"nth"} or not entry["reason"].strip():
            raise Wrong(f"{what}: an entry has {', '.join(sorted(KEYS))} and perhaps nth, and the reason says something")
        try:
            text = text_of(entry["file"])
        except OSError as error:
            raise Wrong(f"{what}: {error}") from error
        lines = [n for n, line in enumerate(text.split("\n"), 1) if line_of(text, n) == entry["line"]]
        if len(lines) != 1:
            raise Wrong(f"{what}: the file holds this line {len(lines)} times, must be once")
        like = [c for c in changes_of(entry["file"], text) if c.line == lines[0] and shown(c) == entry["change"]]
        if len(like) < entry.get("nth", 1):
            raise Wrong(f"{what}: the line offers this change {len(like)} times")
        found[like[entry.get("nth", 1) - 1].id] = entry["reason"]
    return found


def entry_of(change, text):
    """What to write into the file for a change, but for the reason."""
    like = [c.id for c in changes_of(change.file, text) if c.line == change.line and shown(c) == shown(change)]
    entry = {"file": change.file, "line": line_of(text, change.line), "change": shown(change)}
    if len(like) > 1:
        entry["nth"] = like.index(change.id) + 1
    return json.dumps({**entry, "reason": ""}, ensure_ascii=False)
