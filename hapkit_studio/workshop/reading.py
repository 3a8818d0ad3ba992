"""Read a user's file: execute its text, check its declarations, report errors with their line."""

import ast
import io
import linecache
import math
import re
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType, TracebackType

from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import LawError
from hapkit_studio.laws import Law
from hapkit_studio.laws.mistakes import in_unreadable
from hapkit_studio.laws.translate import parse
from hapkit_studio.parameters import AnyParameter, Choice, Parameter
from hapkit_studio.workshop.functions import GIVES
from hapkit_studio.workshop.own import OwnEnvironment, owned, taken_keys
from hapkit_studio.workshop.source import Source, read

_MOST = 300
# (pattern of Python's message, message for students); the groups of the pattern fill the message
_MADE = r"(?:\w+\.)?(\w+)\.__init__\(\) "
_OTHER = (
    (r"cannot import name ('\w+') from '([\w.]+)'.*", r"there is no \1 in \2"),
    (_MADE + r"missing \d+ required positional arguments?: (.+)", r"\1 also needs \2"),
    (_MADE + r"got an unexpected keyword argument (.+)", r"\1 has nothing named \2"),
    (_MADE + r"takes .* but \d+ were given", r"\1 has too many arguments"),
    (
        r"object of type '(?:Parameter|Choice)' has no len\(\)",
        "`parameters` must be a list in brackets; a list of one parameter ends with a comma: (Parameter(…),)",
    ),
    (r"'(?:Parameter|Choice)' object is not iterable", "`parameters` must be a list in brackets"),
)


def without_line(error: LawError) -> str:
    """Return the text of an error without its line."""
    return str(error).removeprefix(f"Line {error.line}: ")


def law_error(error: BaseException, file: str, otherwise: int = 0) -> LawError:
    """Return the LawError for an exception that was raised while a file was executed.

    Its line is the last line of this file in the traceback, or ``otherwise`` if the file is not in the
    traceback.
    """
    line, inside = _line_in(error.__traceback__, file)
    line = line or otherwise
    if isinstance(error, LawError):
        return error if error.line else LawError(without_line(error), line)
    return LawError(_short(_text_for(error, inside)), line)


def _text_for(error: BaseException, inside: bool) -> str:
    """Return the text for an exception; ``inside`` is true if a line of the user's file raised it."""
    match error:
        case NameError(name=str(name)):
            return f"'{name}' is not defined"
        case AttributeError(name="state_names"):
            return "the function of the force is not a law: write `@law` above its `def`"
        case AttributeError(name="key"):
            return "`parameters` must contain only Parameter(…) and Choice(…)"
        case KeyError(args=[key, *_]):
            return f"there is no key {key!r}"
        case ModuleNotFoundError(name=name):
            return f"there is no module '{name}'"
        case RecursionError():
            return (
                "a function calls itself endlessly"
                if inside
                else "a line of the law has too many brackets inside one another"
            )
        case MemoryError():
            return "the file needs too much memory"
        case SystemExit() | EOFError() | KeyboardInterrupt():
            return "a file must not end the program or ask for input"
        case ZeroDivisionError():
            return "a division by zero"
    message = str(error).strip()
    for pattern, text in _OTHER:
        if found := re.fullmatch(pattern, message):
            return found.expand(text)
    return f"{message or 'an error'} ({type(error).__name__})"


def _line_in(traceback: TracebackType | None, file: str) -> tuple[int, bool]:
    """Return the last line of a file in a traceback, and whether the innermost frame is in this file."""
    line, inside = 0, False
    while traceback is not None:
        inside = traceback.tb_frame.f_code.co_filename == file
        line = traceback.tb_lineno if inside else line
        traceback = traceback.tb_next
    return line, inside


def _short(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= _MOST else line[: _MOST - 1] + "…"


NAME = "ENVIRONMENT"
_KEY = re.compile(r"[a-z][a-z0-9_]*")


def checked_environment(module: ModuleType, tree: ast.Module, lines: int) -> Environment:
    """Return a module's checked ENVIRONMENT; raise LawError for a mistake.

    The error contains the line of the mistake in ``tree``, but at most line ``lines``.
    """
    made = getattr(module, NAME, None)
    if made is None and not _environment_line(tree):
        text = f"the file defines no environment: end it with `{NAME} = Environment(…)`"
        raise LawError(text, max(lines, 1))
    if not isinstance(made, Environment):
        kind = "a law" if isinstance(made, Law) else f"'{type(made).__name__}'"
        raise LawError(f"{NAME} is {kind}: write `{NAME} = Environment(…)`", _environment_line(tree))
    _check_texts(made, tree)
    seen: set[str] = set()
    for parameter in made.parameters:
        complaint = _parameter_fault(parameter)
        if not complaint and parameter.key in seen:
            complaint = f"two parameters have the same name '{parameter.key}'"
        if complaint:
            raise LawError(complaint, _call_line(tree, parameter) or _environment_line(tree))
        seen.add(parameter.key)
    return made


def _check_texts(made: Environment, tree: ast.Module) -> None:
    """Raise LawError unless key, title and other texts are valid."""
    if not isinstance(made.key, str) or not _KEY.fullmatch(made.key):
        raise LawError(
            f'`key` must consist of a–z, 0–9 and _, like "my_wall", not {made.key!r}',
            _keyword_line(tree, "key"),
        )
    if made.key in taken_keys():
        raise LawError(
            f'the key "{made.key}" is already used by the program: choose another one',
            _keyword_line(tree, "key"),
        )
    for name in ("title", "summary", "formula", "symbols", "explanation", "scene", "restless"):
        if not isinstance(getattr(made, name), str):
            raise LawError(f"`{name}` must be text in quotation marks", _keyword_line(tree, name))
    if not made.title.strip():
        raise LawError(
            "`title` is the environment's name: it must not be empty", _keyword_line(tree, "title")
        )
    if not all(type(p) in (Parameter, Choice) for p in made.parameters):
        raise LawError(
            "`parameters` must contain only Parameter(…) and Choice(…)", _keyword_line(tree, "parameters")
        )
    for name in GIVES:
        function = getattr(made, name)
        if function is not None and not callable(function):
            raise LawError(f"`{name}` must be a function", _keyword_line(tree, name))


def _parameter_fault(parameter: AnyParameter) -> str:
    """Return what is wrong with a parameter; "" if it is valid."""
    key = parameter.key
    if not isinstance(key, str) or not key.isidentifier() or key.startswith("_"):
        return f'the first value of a parameter must be its name in the law, like "stiffness", not {key!r}'
    for name in ("label", "unit", "help", "symbol"):
        if not isinstance(getattr(parameter, name), str):
            return f"'{key}': its {name} must be text in quotation marks, not {getattr(parameter, name)!r}"
    return _choice_fault(parameter) if isinstance(parameter, Choice) else _number_fault(parameter)


def _choice_fault(choice: Choice) -> str:
    options = choice.options
    if not isinstance(options, tuple | list) or not options or not all(isinstance(o, str) for o in options):
        return f'\'{choice.key}\': its options must be names in brackets, like ("right", "left")'
    if len(set(options)) < len(options):
        return f"'{choice.key}': two of its options have the same name"
    if choice.default_option and choice.default_option not in options:
        return (
            f"'{choice.key}': its default must be one of {', '.join(options)}, not {choice.default_option!r}"
        )
    return ""


def _number_fault(parameter: Parameter) -> str:
    key, unit = parameter.key, f" {parameter.unit}" if parameter.unit else ""
    for name in ("default", "low", "high"):
        value = getattr(parameter, name)
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            return f"'{key}': its {name} must be a number, not {value!r}"
    if parameter.low >= parameter.high:
        return (
            f"'{key}' has the limits {parameter.low:,g} and {parameter.high:,g}{unit}: write the lower "
            "limit first"
        )
    if not parameter.low <= parameter.default <= parameter.high:
        limits = f"{parameter.low:,g} to {parameter.high:,g}{unit}"
        return f"the default of '{key}' must be from {limits}, not {parameter.default:,g}{unit}"
    return ""


def calls(tree: ast.Module, name: str) -> Iterator[ast.Call]:
    """Yield every call of a function with this name."""
    for node in ast.walk(tree):
        match node:
            case ast.Call(func=ast.Name(id=found)) if found == name:
                yield node


def _environment_line(tree: ast.Module) -> int:
    """Return the line of the last assignment to ENVIRONMENT; 0 without an assignment."""
    names = [n for n in ast.walk(tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]
    return max((n.lineno for n in names if n.id == NAME), default=0)


def _keyword_line(tree: ast.Module, keyword: str) -> int:
    """Return the line of a keyword argument of Environment; without it, the line of ENVIRONMENT."""
    given = [k for call in calls(tree, "Environment") for k in call.keywords if k.arg == keyword]
    return given[0].value.lineno if given else _environment_line(tree)


def _call_line(tree: ast.Module, parameter: AnyParameter) -> int:
    """Return the last line on which a parameter with this key is declared; 0 if it is not found."""
    lines = [0]
    for call in calls(tree, type(parameter).__name__):
        match [*call.args[:1], *(k.value for k in call.keywords if k.arg == "key")]:
            case [ast.Constant(value=key), *_] if key == parameter.key:
                lines.append(call.lineno)
    return max(lines)


def _indentation(error: SyntaxError, lines: list[str]) -> str:
    """Return a message about the indentation that a line needs; "" for other errors."""
    if not isinstance(error, IndentationError) or not 1 < (error.lineno or 1) <= len(lines):
        return ""
    if isinstance(error, TabError):
        return "indent this line by spaces only: tabs and spaces are mixed"
    *above, this = ["" if line.lstrip().startswith("#") else line for line in lines[: error.lineno]]
    opens = re.search(r"on line (\d+)$", error.msg)  # the line with the colon after which a block must follow
    last = lines[int(opens[1]) - 1] if opens else next((line for line in above[::-1] if line.strip()), "")
    if "unindent" in error.msg:
        return f"this line has {_indent(this)} spaces before it: indent it as far as a line above it"
    return f"indent this line by {_indent(last) + (4 if opens else 0)} spaces; it has {_indent(this)}"


def _indent(line: str) -> int:
    """Return the number of leading spaces."""
    return len(line) - len(line.lstrip(" "))


def load(path: str | Path) -> OwnEnvironment:
    """Execute a file and return its ENVIRONMENT; raise LawError with the line of the mistake.

    Security: this executes the file in the studio's process. Ask for consent before loading another person's
    file.
    """
    return load_source(read(Path(path).expanduser().absolute()))


def load_source(source: Source) -> OwnEnvironment:
    """Return the ENVIRONMENT of a file's content; raise LawError for a mistake."""
    return owned(execute(source), source)


def execute(source: Source) -> Environment:
    """Execute a text as a separate module and return its checked ENVIRONMENT.

    Raise LawError for a mistake.
    """
    name, file = str(source.path), f"own_environment_{source.digest[:20]}"
    lines = io.StringIO(source.text, newline="\n").readlines()
    # Tracebacks and laws read the source here. An entry without a time is never compared with a file.
    linecache.cache[name] = (len(source.text), None, lines, name)
    module = ModuleType(file)
    module.__file__ = name
    sys.modules[file] = module
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = parse(source.text, name)
            exec(compile(source.text, name, "exec", dont_inherit=True), module.__dict__)
        return checked_environment(module, tree, len(lines))
    except SyntaxError as error:
        if error.filename not in (name, None):
            raise law_error(error, name) from None
        line = min(error.lineno or 1, max(len(lines), 1))
        usual = in_unreadable(lines[line - 1]) if lines else None
        text = usual or _indentation(error, lines) or f"Python cannot read this line: {error.msg}"
        raise LawError(_short(text), line) from None
    except (Exception, SystemExit) as error:
        raise law_error(error, name) from None
    finally:
        sys.modules.pop(file, None)
