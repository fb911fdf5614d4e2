"""What may be changed in a source, by its tokens alone: every place where an operator, a constant, a condition or a call
stands, and what would stand there instead. syntax.py then judges whether the compiler takes the place for what it seems.
"""
import dataclasses
import re

from .cpp_tokens import tokens_of

# Token -> (name of the change, what stands there instead).
COMPARISONS = {"<": ("le", "<="), "<=": ("lt", "<"), ">": ("ge", ">="), ">=": ("gt", ">"), "==": ("ne", "!="),
               "!=": ("eq", "==")}
ARITHMETIC = {"+": ("minus", "-"), "-": ("plus", "+"), "*": ("divided", "/"), "/": ("times", "*"), "+=": ("minus", "-="),
              "-=": ("plus", "+="), "*=": ("divided", "/="), "/=": ("times", "*=")}
LOGIC = {"&&": ("or", "||"), "||": ("and", "&&")}
EXTREMES = {"min": ("max", "max"), "max": ("min", "min"), "min_element": ("max", "max_element"),
            "max_element": ("min", "min_element")}
TRUTH = {"true": ("false", "false"), "false": ("true", "true")}
NO_CALL = {"return", "if", "for", "while", "switch", "do", "else", "throw", "delete", "new", "using", "const", "auto",
           "static", "constexpr", "case", "default", "goto", "break", "continue", "try", "catch", "co_await", "co_yield",
           "co_return", "static_assert", "typedef", "template", "struct", "class", "enum", "namespace", "public", "private",
           "protected", "explicit", "virtual", "friend", "inline", "extern", "operator", "typename", "requires"}
INTEGER = re.compile(r"(0[xX][0-9a-fA-F']+|0[bB][01']+|\d[\d']*)([a-zA-Z_]\w*)?")
FLOATING = re.compile(r"((?:\d[\d']*\.?[\d']*|\.\d[\d']*)(?:[eE][+-]?\d+)?)([a-zA-Z_]\w*)?")


@dataclasses.dataclass(frozen=True)
class Change:
    file: str  # relative to the source tree
    begin: int  # bytes of the file
    end: int
    kind: str  # comparison, arithmetic, logic, not, extreme, number, truth, condition, call
    name: str
    old: str
    new: str
    line: int
    column: int
    place: int  # where the syntax that is to be judged begins: the `if` of a condition
    in_brackets: bool = False  # a number straight behind [: an index or the length of an array

    @property
    def id(self):
        return f"{self.file}:{self.line}:{self.column}:{self.name}"


def other_number(text):
    """n -> n + 1, 0.5 -> 0.6, 0.0 -> 1.0; none for what is not understood."""
    found = INTEGER.fullmatch(text)
    if found:
        digits, suffix = found.group(1).replace("'", ""), found.group(2) or ""
        if digits[:2] in ("0x", "0X"):
            return f"{int(digits, 16) + 1:#x}{suffix}"
        if digits[:2] in ("0b", "0B"):
            return f"{int(digits, 2) + 1:#b}{suffix}"
        if len(digits) > 1 and digits[0] == "0":
            return f"0{int(digits, 8) + 1:o}{suffix}"
        return f"{int(digits) + 1}{suffix}"
    found = FLOATING.fullmatch(text)
    if found:
        value = float(found.group(1).replace("'", ""))
        return f"{float(f'{value * 1.2:.12g}') if value else 1.0!r}{found.group(2) or ''}"
    return None


def negated(tokens, i, text):
    """The condition of the `if` or `while` at i, as (first byte, byte behind); none where it cannot be negated."""
    opening = tokens[i + 1] if i + 1 < len(tokens) else None
    if opening is None or opening.text != "(" or opening.mate < 0:
        return None
    inside = tokens[i + 2:opening.mate]
    for k in range(len(inside) - 1, -1, -1):
        if inside[k].text == ";":  # behind the initial statement
            inside = inside[k + 1:]
            break
    return (inside[0].begin, inside[-1].end) if inside else None


def call(tokens, i):
    """The end of the statement at i when it may be a call whose value nobody takes; none otherwise."""
    before = tokens[i - 1].text if i else ""
    if before not in (";", "{", "}", ")", "else", "do") or tokens[i].text in NO_CALL:
        return None
    k = i
    while k < len(tokens) and tokens[k].text not in (";", "=", "}"):
        k = tokens[k].mate + 1 if tokens[k].mate > k else k + 1
    ends = k < len(tokens) and tokens[k].text == ";" and tokens[k - 1].text == ")"
    return tokens[k - 1].end if ends else None


def change_at(tokens, i, text):
    """The one change that token i offers: kind, name, first byte, byte behind, new text; none for most tokens."""
    token = tokens[i]
    before = tokens[i - 1].text if i else ""
    after = tokens[i + 1].text if i + 1 < len(tokens) else ""
    if token.in_template or before == "operator" or token.kind == "text":
        return None
    whole = (token.begin, token.end)
    if token.spaced:
        for kind, table in (("comparison", COMPARISONS), ("arithmetic", ARITHMETIC), ("logic", LOGIC)):
            if token.text in table:
                name, new = table[token.text]
                return (kind, name, *whole, new)
    if token.text == "!":
        return ("not", "not", *whole, "!!")
    if token.kind == "number":
        new = other_number(token.text)
        return ("number", "constant", *whole, new) if new else None
    if token.text in TRUTH:
        name, new = TRUTH[token.text]
        return ("truth", name, *whole, new)
    if token.text in EXTREMES and before == "::" and after in ("(", "<"):
        empty = after == "(" and tokens[i + 1].mate == i + 2  # numeric_limits::max()
        name, new = EXTREMES[token.text]
        return None if empty else ("extreme", name, *whole, new)
    if token.text in ("if", "while"):
        span = negated(tokens, i, text)
        return ("condition", "negated", *span, f"!({text[span[0]:span[1]]})") if span else None
    if token.kind == "word":
        end = call(tokens, i)
        return ("call", "removed", token.begin, end, "") if end else None
    return None


def changes_of(file, text):
    """All changes that the tokens of a source offer, in their order. `text` is the source read as Latin-1."""
    tokens = tokens_of(text)
    found = []
    for i, token in enumerate(tokens):
        change = change_at(tokens, i, text)
        if change:
            kind, name, begin, end, new = change
            line_begin = text.rfind("\n", 0, token.begin) + 1
            found.append(Change(file, begin, end, kind, name, text[begin:end], new, text.count("\n", 0, token.begin) + 1,
                                token.begin - line_begin + 1, token.begin, i > 0 and tokens[i - 1].text == "["))
    return found


def line_of(text, number):
    return text.split("\n")[number - 1].strip().encode("latin-1").decode("utf-8", "replace")


def changed(text, change):
    return text[:change.begin] + change.new + text[change.end:]


def shown(change):
    """What became what, on one line of bounded length."""
    def short(words):
        words = re.sub(r"\s+", " ", words).encode("latin-1").decode("utf-8", "replace")
        return words if len(words) <= 60 else words[:57] + "..."
    return f"{short(change.old)} -> {short(change.new) or 'nothing'}"
