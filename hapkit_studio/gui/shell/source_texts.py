"""Finds the messages of the window in the program's source: texts that a student sees only after an event.

A message is a literal of two or more words that begins with a capital letter or with a value (an error
message about a law may begin with any letter, like Python's own messages). Values are in braces, by name:
``{1000.0 * found.travel}`` becomes ``{travel}``, and a constant becomes its value. Tags are removed.

Left out are texts that are not shown in the window: docstrings, assertions, programming errors, log entries,
annotations, objects' names, patterns, SQL, shell commands, code of laws and sketches, and modules that only
the command line uses. Left out, too, are pieces that another text contains (they begin with a lower-case
letter or a punctuation mark, or end with a word like "the"), and templates with more values than words.
"""

import ast
import re
from collections.abc import Iterator
from html import unescape
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

_FOLDERS = (
    "gui",
    "analysis",
    "charts",
    "haptics",
    "devices",
    "environments",
    "laws",
    "lessons",
    "sessions",
    "workshop",
)
_COMMAND_LINE = ("analysis/cluster", "analysis/survey", "analysis/sweeps", "charts/survey", "sessions/export")
_CODE = (
    "laws/reference",
    "laws/machine",
    "laws/c_source",
    "laws/native",
    "haptics/clib",
    "gui/shell/source_texts",
    "gui/shell/texts",
    "gui/widgets/theme",
)
_ERRORS = {"AssertionError", "KeyError", "NotImplementedError", "RuntimeError", "TypeError"}
_SILENT = {
    *(
        "compile",
        "match",
        "search",
        "fullmatch",
        "findall",
        "sub",
        "split",
        "replace",
        "execute",
        "executescript",
    ),
    *(
        "setObjectName",
        "setStyleSheet",
        "cast",
        "getattr",
        "TypeVar",
        "debug",
        "info",
        "exception",
        "startswith",
    ),
    *("endswith", "removesuffix", "removeprefix", "QSettings", "namedtuple", "option", "environ"),
}
_LAWS = ("laws/mistakes", "laws/subset", "laws/translate", "workshop/reading", "workshop/trying")
_LAW_ERROR = re.compile(
    r"\b(is|are|has|must|cannot|needs|takes|returns|goes|belongs|assigns|counts|write|use)\b"
)
# an axis title such as "vibration, Hz"
_AXIS = re.compile(r"^[^\W\d][^.:;{}]*, (?:\w{1,3}|\S*[/·%°µ]\S*|counts?|JND)$")
_WORD = re.compile(r"[^\W\d_]{2,}")
# code, style sheets, patterns, SQL, shell commands, file filters, and pieces of texts
_NO_MESSAGE = re.compile(
    r"\{;|^[#&./<%]|::|^(from|import|def|class|return|for|const|constexpr|sudo|echo) |^@|\| None|\|\||\n.*\n|"
    r"^\w+\[|^\w+ = |^\w+, \w+ = |\\[dwsb(\[12]|\(\?:|^SELECT |^[A-Z]{2,} [A-Za-z_*]+|=\"\{|;;|"
    r"^[A-Z]\w+ [A-Z]\w+[A-Z]\w+|\(\*\.|--\w| // |constexpr|"
    r"==\"|\\[A-Z]|\b_np\.|\b(the|a|an|of|to|with|than|and|or) *$"
)


class Message(NamedTuple):
    """A message and its origin: the source file's path without the ending, and the line."""

    module: str
    line: int
    text: str


def messages() -> Iterator[Message]:
    """Yield the messages of the window."""
    top = Path(str(files("hapkit_studio")))
    for path in sorted(path for folder in _FOLDERS for path in (top / folder).rglob("*.py")):
        module = path.relative_to(top).with_suffix("").as_posix()
        if module not in _COMMAND_LINE + _CODE:
            yield from _in_module(module, ast.parse(path.read_text("utf-8")))


def _in_module(module: str, tree: ast.Module) -> Iterator[Message]:
    values = import_module(f"hapkit_studio.{module.replace('/', '.').removesuffix('.__init__')}")
    silent = {id(part) for node in ast.walk(tree) for part in _silent(node)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant | ast.JoinedStr) and id(node) not in silent:
            text = re.sub(r"\{\d*\}", "{value}", without_tags(_text(node, values)))
            if is_message(text, law=module in _LAWS):
                yield Message(module, node.lineno, " ".join(text.split()))


def without_tags(text: str) -> str:
    """Remove tags from a rich text, and replace entities by their characters."""
    text = re.sub(r"</?(?:p|br|tr|td|h\d|li)\b[^<>]*>", " ", text)
    return unescape(re.sub(r"</?[a-z][^<>]*>", "", text)).replace("\N{WORD JOINER}", "")


def is_message(text: str, *, law: bool = False) -> bool:
    """Return True for a whole text of several words; False for a piece of a text, a template or code."""
    if re.fullmatch(r"(The|A|An|Its) \S+( \S+)?", text) and not text.endswith(
        "."
    ):  # the subject of a sentence
        return False
    own = _WORD.findall(re.sub(r"\{[^}]*\}", " ", text))
    if len(own) < max(2, text.count("{")) or " " not in text.strip() or _NO_MESSAGE.search(text):
        return False
    whole = re.match(r"[\"“(]?[^\W\d_a-z]|\{", text) or _AXIS.match(text)
    return bool(whole or (law and re.match(r"[\w`']", text) and _LAW_ERROR.search(text)))


def _silent(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the inner nodes whose texts are not shown: parts of an f-string, docstrings, patterns."""
    match node:
        case ast.JoinedStr():
            yield from (part for value in node.values for part in ast.walk(value))
        case ast.Expr(value=ast.Constant()):
            yield node.value
        case ast.Assert(msg=ast.AST() as message):
            yield from ast.walk(message)
        case ast.Raise(exc=ast.Call(func=ast.Name(id=name))) if name in _ERRORS:
            yield from ast.walk(node)
        case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name)) if name in _SILENT:
            yield from (part for value in [*node.args, *node.keywords] for part in ast.walk(value))
        case ast.Subscript():
            yield from ast.walk(node.slice)
        case ast.Compare():
            yield from node.comparators
        case ast.AnnAssign(annotation=kind) | ast.arg(annotation=ast.AST() as kind):
            yield from ast.walk(kind)
        case ast.FunctionDef(returns=ast.AST() as kind):
            yield from ast.walk(kind)
        case ast.keyword(arg="loc" | "style" | "xycoords" | "textcoords" | "kind"):
            yield from ast.walk(node.value)


def _text(node: ast.AST, values: ModuleType) -> str:
    """Return a literal's text with its values in braces; "" if it is not a text."""
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else ""
    assert isinstance(node, ast.JoinedStr)
    return "".join(
        _value(part, values) if isinstance(part, ast.FormattedValue) else str(part.value)  # type: ignore[attr-defined]
        for part in node.values
    )


def _value(part: ast.FormattedValue, values: ModuleType) -> str:
    """Return a constant's value, the longer of two alternative literals, or the value's name in braces."""
    match part.value:
        case ast.Name(id=name) if name.isupper() and hasattr(values, name):
            spec = _text(part.format_spec, values) if part.format_spec else ""
            return format(getattr(values, name), spec)
        case ast.IfExp(
            body=ast.Constant() | ast.JoinedStr() as body, orelse=ast.Constant() | ast.JoinedStr() as other
        ):
            return max(_text(body, values), _text(other, values), key=len)
    return f"{{{_name(part.value)}}}"


def _name(node: ast.AST) -> str:
    """Return the name of the value that an expression shows: "travel" for ``number(found.travel, 1)``."""
    match node:
        case ast.Name(id=name) | ast.Attribute(attr=name):
            return name.strip("_").replace("_", " ").lower()
        case ast.Call(args=[first, *_]) if _name(first):
            return _name(first)
        case ast.Call(func=ast.Attribute(value=ast.Name(id="self"), attr=name)):
            return name.strip("_").replace("_", " ")
        case ast.Call(func=ast.Attribute(value=owner)) if not isinstance(owner, ast.Constant):
            return _name(owner)
        case ast.Call(func=function):
            return _name(function)
        case ast.BoolOp(values=[first, *_]):
            return _name(first)
        case ast.BinOp(left=left, right=right):
            return _name(left) or _name(right)
        case ast.UnaryOp(operand=inner) | ast.Subscript(value=inner) | ast.IfExp(body=inner):
            return _name(inner)
        case ast.GeneratorExp(elt=inner) | ast.ListComp(elt=inner):
            return _name(inner)
        case ast.JoinedStr(values=parts):
            return next((_name(part.value) for part in parts if isinstance(part, ast.FormattedValue)), "")
    return ""
