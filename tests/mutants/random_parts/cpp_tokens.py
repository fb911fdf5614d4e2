"""A C++ source as tokens, each with its place: comments, strings and directives are told from code, and the angle
brackets of templates from comparisons. The latter rests on clang-format's spaces, which every source of the house has: a
comparison has them on both sides, a template's bracket does not. Texts are Latin-1, so that places are bytes, as clang's.
"""
import dataclasses
import re

PATTERN = re.compile(r"""
    (?P<comment>//(?:\\\n|[^\n])*|/\*.*?\*/)
  | (?P<text>(?:u8|[uUL])?R"(?P<mark>[^()\s\\]{0,16})\(.*?\)(?P=mark)"
      | (?:u8|[uUL])?"(?:\\.|[^"\\\n])*"
      | (?:u8|[uUL])?'(?:\\.|[^'\\\n])+')
  | (?P<directive>^[ \t]*\#(?:\\\n|[^\n])*)
  | (?P<number>\.?\d(?:[eEpP][+-]|'[0-9a-zA-Z]|[\w.])*)
  | (?P<word>[A-Za-z_]\w*)
  | (?P<sign><=>|<<=|>>=|->\*|\.\.\.|::|->|\+\+|--|<<|>>|<=|>=|==|!=|&&|\|\||[-+*/%&|^]=|[^\s\w])
""", re.VERBOSE | re.DOTALL | re.MULTILINE)
OPENING = {"(": ")", "[": "]", "{": "}"}


@dataclasses.dataclass
class Token:
    kind: str  # text, number, word or sign
    text: str
    begin: int
    in_template: bool = False  # between the angle brackets of a template, or one of them
    mate: int = -1  # index of the bracket that closes this one
    spaced: bool = False  # white space before and behind

    @property
    def end(self):
        return self.begin + len(self.text)


def opens_template(tokens, i, text):
    token = tokens[i]
    before = tokens[i - 1].text if i else ""
    return token.text == "<" and before != "operator" and (before == "template" or not text[token.begin - 1].isspace())


def pair(tokens, text):
    """Finds the mate of each bracket, and what lies between angle brackets."""
    stack = []
    for i, token in enumerate(tokens):
        token.in_template = any(mark == "<" for mark, _ in stack)
        if token.kind != "sign":
            continue
        if token.text in OPENING:
            stack.append((token.text, i))
        elif opens_template(tokens, i, text):
            token.in_template = True
            stack.append(("<", i))
        elif token.text in (">", ">>"):
            for _ in token.text:
                if stack and stack[-1][0] == "<":
                    stack.pop()
        elif token.text in OPENING.values():
            while stack and stack[-1][0] == "<":
                stack.pop()
            if stack:
                tokens[stack.pop()[1]].mate = i


def tokens_of(text):
    tokens = []
    for found in PATTERN.finditer(text):
        kind = found.lastgroup if found.lastgroup != "mark" else "text"
        if kind in ("comment", "directive"):
            continue
        begin, end = found.span()
        spaced = text[begin - 1:begin].isspace() and text[end:end + 1].isspace()
        tokens.append(Token(kind, found.group(), begin, spaced=spaced))
    pair(tokens, text)
    return tokens
