"""Weaves many mutants into copies of their sources: each place becomes a choice between the two, made while the program
runs. So a room is compiled and linked once for all its mutants, and the tests tell which places they reach.

Where the choice stands is read from clang's syntax tree: around the whole expression for an operator, around the call for a
removed one. What cannot be chosen while a program runs (a constant of a template, `if constexpr`, operands of two types) fails to
compile; trial.py then takes it out and builds it alone.
"""
import dataclasses
import pathlib

from .changes import Change

HEADER = pathlib.Path(__file__).resolve().parent / "woven.h"
ON = "::tactbench::mutants::on"


class Unwoven(Exception):
    """The place cannot become a choice."""


@dataclasses.dataclass(frozen=True)
class Weave:
    change: Change
    begin: int  # of what the choice stands around
    end: int
    once: bool  # worked out once a process and kept: the test that does so need not be the one that sees it
    constant: int = -1  # where the `constexpr` stands that has to become `const`


def one_line(text):
    """The same code without line ends, so that the lines behind it keep their numbers."""
    if "//" in text or "/*" in text or "\n#" in text or 'R"' in text:
        raise Unwoven
    return text.replace("\n", " ")


def choice(number, weave, text, inner):
    change = weave.change
    chosen = f"{ON}({number})"
    if change.kind in ("condition", "not"):
        return f"({chosen} != static_cast<bool>({inner}))"
    if change.kind == "call":
        return f"({chosen} ? void() : static_cast<void>({inner}))"
    mutated = one_line(text[weave.begin:change.begin] + change.new + text[change.end:weave.end])
    return f"({chosen} ? ({mutated}) : ({inner}))"


def rendered(text, begin, end, weaves):
    """The text between two places; `weaves` are (number, Weave) in it, in the order of `outermost_first`."""
    out, at = [], begin
    while weaves:
        number, first = weaves[0]
        inside = [w for w in weaves[1:] if w[1].begin < first.end]
        if any(w[1].end > first.end for w in inside):
            raise Unwoven
        out += [text[at:first.begin], choice(number, first, text, rendered(text, first.begin, first.end, inside))]
        at, weaves = first.end, weaves[1 + len(inside):]
    return "".join([*out, text[at:end]])


def outermost_first(numbered):
    number, weave = numbered
    return weave.begin, -weave.end, weave.change.kind != "condition", number


def woven(text, weaves, path):
    """The text of a copy of the source at `path`, read as Latin-1, with all the choices of {number: Weave}."""
    for weave in weaves.values():
        if weave.constant >= 0:
            at = weave.constant
            text = text[:at] + "const".ljust(len("constexpr")) + text[at + len("constexpr"):]
    body = rendered(text, 0, len(text), sorted(weaves.items(), key=outermost_first))
    return f'#include "{HEADER}"\n#line 1 "{path}"\n{body}'
