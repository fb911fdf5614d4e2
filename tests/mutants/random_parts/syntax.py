"""Judges by clang's syntax tree whether a change is one of running code that the compiler should accept: the operator is one
of numbers (not of strings or paths), the constant is computed with (no template argument, default argument, case label,
enumerator, array length or static_assert), the call is a statement of its own.
"""
import os

from clang import cindex
from clang.cindex import CursorKind as K
from clang.cindex import StorageClass, TypeKind

from .weave import Weave

NEVER_BELOW = {K.STATIC_ASSERT, K.ENUM_CONSTANT_DECL, K.PARM_DECL, K.TEMPLATE_TYPE_PARAMETER, K.TEMPLATE_NON_TYPE_PARAMETER,
               K.TEMPLATE_TEMPLATE_PARAMETER}
CODE = {K.COMPOUND_STMT, K.VAR_DECL, K.CONSTRUCTOR, K.FIELD_DECL}
BUILT_IN = {K.BINARY_OPERATOR, K.COMPOUND_ASSIGNMENT_OPERATOR}
LITERALS = {K.INTEGER_LITERAL, K.FLOATING_LITERAL, K.CXX_BOOL_LITERAL_EXPR}
HOLDS_STATEMENTS = {K.COMPOUND_STMT, K.IF_STMT, K.FOR_STMT, K.WHILE_STMT, K.DO_STMT, K.CXX_FOR_RANGE_STMT, K.CASE_STMT,
                    K.DEFAULT_STMT}
POINTERS = {TypeKind.POINTER, TypeKind.CONSTANTARRAY, TypeKind.INCOMPLETEARRAY}
SEEN_BY_CLANG = ("-I", "-D", "-std", "-U")  # of the compiler's options; -isystem and -include beside them


def options_for_clang(words):
    """Of a compile command those words that say what the source means."""
    chosen = ["-xc++", "-w"]
    for i, word in enumerate(words):
        if word.startswith(SEEN_BY_CLANG):
            chosen.append(word)
        elif word in ("-isystem", "-include", "-iquote") and i + 1 < len(words):
            chosen += words[i:i + 2]
    return chosen


def covers(cursor, begin, end):
    return cursor.extent.start.offset <= begin and end <= cursor.extent.end.offset


def children(cursor):
    return list(cursor.get_children())


def bare(cursor):
    """Without the nodes that libclang has no name for: conversions, temporaries."""
    while cursor.kind == K.UNEXPOSED_EXPR and len(children(cursor)) == 1:
        cursor = children(cursor)[0]
    return cursor


def plain_type(cursor):
    """Canonical, without reference and const."""
    kind = cursor.type.get_canonical()
    if kind.kind in (TypeKind.LVALUEREFERENCE, TypeKind.RVALUEREFERENCE):
        kind = kind.get_pointee()
    return kind, kind.spelling.replace("const ", "").strip()


class Syntax:
    """Reads sources, and keeps the last few: a draw comes back to them."""
    KEPT = 4

    def __init__(self):
        self.index = cindex.Index.create()
        self.read = {}  # path -> (translation unit, the declarations of the source itself), the oldest first
        self.unreadable = {}  # path -> the first error

    def tops(self, path, options):
        if path not in self.read:
            while len(self.read) >= self.KEPT:
                del self.read[next(iter(self.read))]
            unit = self.index.parse(path, args=options)
            errors = [d for d in unit.diagnostics if d.severity >= cindex.Diagnostic.Error]
            if errors:
                self.unreadable[path] = str(errors[0])
            own = os.path.realpath(path)
            tops = [] if errors else [c for c in unit.cursor.get_children()
                                      if c.extent.start.file and os.path.realpath(c.extent.start.file.name) == own]
            self.read[path] = (unit, tops)
        return self.read[path][1]

    def chain(self, cursors, begin, end):
        """All nodes that cover the bytes, from the outermost inwards."""
        for cursor in cursors:
            if covers(cursor, begin, end):
                yield cursor
                yield from self.chain(cursor.get_children(), begin, end)

    def weave(self, change, path, options):
        """Where an accepted change becomes a choice; none when the tree does not tell."""
        nodes = list(self.chain(self.tops(path, options), change.begin, change.end))
        span = SPANS.get(change.kind, own_span)(change, nodes)
        variables = [n for n in nodes if n.kind == K.VAR_DECL]
        within = K.COMPOUND_STMT in {n.kind for n in nodes}
        once = bool(variables) and (not within or any(n.storage_class == StorageClass.STATIC for n in variables))
        constant = -1
        for node in variables:
            for token in node.get_tokens():
                if token.spelling == "constexpr":
                    constant, once = token.extent.start.offset, True
                if token.extent.start.offset >= node.location.offset:
                    break
        return Weave(change, *span, once, constant) if span else None

    def accepts(self, change, path, options):
        """Whether the change is a mutant; `options` are those for clang."""
        begin, end = change.begin, change.end
        nodes = list(self.chain(self.tops(path, options), begin, end))
        kinds = {n.kind for n in nodes}
        if kinds & NEVER_BELOW or not kinds & CODE:
            return False
        if any(n.kind == K.CASE_STMT and covers(children(n)[0], begin, end) for n in nodes):
            return False
        judge = {"comparison": operator, "arithmetic": operator, "logic": operator, "not": negation, "extreme": extreme,
                 "number": literal, "truth": literal, "condition": condition, "call": call}[change.kind]
        return judge(change, nodes)


def operator(change, nodes):
    for node in nodes:
        parts = children(node)
        if node.kind in BUILT_IN and len(parts) == 2:
            left, right = parts
            if left.extent.end.offset <= change.begin and change.end <= right.extent.start.offset:
                return change.kind != "arithmetic" or numbers(change, left, right)
    calls = [n for n in nodes if n.kind == K.CALL_EXPR and n.spelling == f"operator{change.old}"]
    overloaded = any(n.kind in (K.DECL_REF_EXPR, K.OVERLOADED_DECL_REF) and n.spelling.startswith("operator") and
                     n.extent.start.offset == change.begin for n in nodes)
    if change.kind == "comparison":
        return overloaded
    return change.kind == "arithmetic" and overloaded and bool(calls) and quantities(change, calls[-1])


def numbers(change, left, right):
    """Of two pointers there is no sum, and a pointer is not taken from a number."""
    pointers = [side.type.get_canonical().kind in POINTERS for side in (left, right)]
    return not (pointers[1] or (pointers[0] and change.old not in ("+", "-", "+=", "-=")))


def quantities(change, node):
    """Whether the opposite of an overloaded operator exists: for two of one type, and for a quantity scaled by a number."""
    arguments = list(node.get_arguments())
    if len(arguments) != 2:
        return False
    (left, left_name), (_, right_name) = (plain_type(a) for a in arguments)
    _, result = plain_type(node)
    matrices = "Eigen::" in left_name and "Eigen::" in right_name
    if change.old in ("+", "-", "+=", "-="):
        if "basic_string" in left_name or "filesystem" in left_name:
            return False
        moved = "duration<" in right_name and left_name.startswith("std::chrono::")
        return matrices or moved or (left_name == right_name == result)
    return left.kind == TypeKind.RECORD and right_name in ("double", "int", "float", "long") and result == left_name


def negation(change, nodes):
    return any(n.extent.start.offset == change.begin and
               (n.kind == K.UNARY_OPERATOR or (n.kind == K.CALL_EXPR and n.spelling == "operator!")) for n in nodes)


def extreme(change, nodes):
    return any(n.kind in (K.DECL_REF_EXPR, K.OVERLOADED_DECL_REF, K.UNEXPOSED_EXPR) for n in nodes)


def literal(change, nodes):
    found = [i for i, n in enumerate(nodes) if n.extent.start.offset == change.begin and
             (n.kind in LITERALS or (n.kind == K.CALL_EXPR and n.spelling.startswith('operator""')))]
    if not found:
        return False
    above = [n.kind for n in nodes[:found[0]] if n.kind != K.UNEXPOSED_EXPR]
    return not change.in_brackets or above[-1] in (K.ARRAY_SUBSCRIPT_EXPR, K.CALL_EXPR)


def condition(change, nodes):
    """An `if` or `while` whose condition declares nothing and is none of the preprocessing of templates."""
    for node in nodes:
        if node.kind in (K.IF_STMT, K.WHILE_STMT) and node.extent.start.offset == change.place:
            return not any(c.kind in (K.VAR_DECL, K.DECL_STMT) and c.extent.end.offset > change.begin and
                           c.extent.start.offset < change.end for c in children(node))
    return False


def call(change, nodes):
    for node in nodes:
        if node.kind not in HOLDS_STATEMENTS:
            continue
        for child in children(node):
            if (child.extent.start.offset, child.extent.end.offset) == (change.begin, change.end):
                inner = bare(child)
                return inner.kind == K.CALL_EXPR and (inner.spelling == "operator()" or
                                                      not inner.spelling.startswith("operator"))
    return False


def own_span(change, nodes):
    return change.begin, change.end


def span_of_operator(change, nodes):
    """The expression whose operator it is: the innermost with operands on both sides."""
    for node in reversed(nodes):
        begin, end = node.extent.start.offset, node.extent.end.offset
        if node.kind in (*BUILT_IN, K.CALL_EXPR) and begin < change.begin and change.end < end:
            return begin, end
    return None


def span_of_negation(change, nodes):
    for node in reversed(nodes):
        if node.kind in (K.UNARY_OPERATOR, K.CALL_EXPR) and node.extent.start.offset == change.begin:
            return change.begin, node.extent.end.offset
    return None


def span_of_extreme(change, nodes):
    """The call of std::min, std::max and their like."""
    for node in reversed(nodes):
        if node.kind == K.CALL_EXPR and node.extent.end.offset > change.end:
            return node.extent.start.offset, node.extent.end.offset
    return None


SPANS = {"comparison": span_of_operator, "arithmetic": span_of_operator, "logic": span_of_operator, "not": span_of_negation,
         "extreme": span_of_extreme}
