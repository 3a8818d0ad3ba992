"""The law language: a rejected construct is reported with its line and a message."""

import pytest

from hapkit_studio.errors import LawError
from hapkit_studio.laws import Law, law
from tests.laws.law_files import HEAD, PARAMETERS, environment, law_text

# columns: the rejected line, after which the law returns 0.0, and words of the message
REFUSED = [
    ("while x > 0: v = 1.0", "`while` is not allowed"),
    ("try: a = 1.0\nexcept: a = 2.0", "`try` is not allowed"),
    ("import os", "write `import` at the top"),
    ("a = [1.0, 2.0]", "a list is not allowed"),
    ("a = {1.0, 2.0}", "a set is not allowed"),
    ("a = {1.0: 2.0}", "a dictionary is not allowed"),
    ("a = max(i for i in range(3))", "a generator is not allowed"),
    ("f = lambda a: a", "`lambda` is not allowed"),
    ("def inner(): return 1.0", "a function inside a law"),
    ("a = (1.0, 2.0)", "several values at once"),
    ("a, b = x, v, dt", "there are 2 names here, but 3 values"),
    ("a, b = x", "there are 2 names here, but one value"),
    ("a, b = half(x)", "`half` returns 1 value: store them with `a = half(…)`"),
    ("a = both(x)", "`both` returns 2 values: store them with `a, b = both(…)`"),
    ("a, x = v, 1.0", "cannot assign a value to `x`"),
    ("return x, v", "several values at once are allowed only in"),
    ("a = b = 1.0", "one name at a time"),
    ("*a, b = x, v", "only names and the state"),
    ("a = max(*x)", "`*` before a name"),
    ("a = -p.stifness * x", "'p.stifness' is not a parameter; available: stiffness, damping, side"),
    ("a = stifness * x", "'stifness' is not defined"),
    ("a = s.memory", "'s.memory' is not a state of this law; available: last, ring"),
    ("a = s.last[0]", "one value: use it without an index"),
    ("a = s.ring", "several values: choose one with an index"),
    ("a = s.ring[0:1]", "not allowed"),
    ("p.stiffness = 2.0", "only names and the state `s` can be assigned"),
    ("x = 2.0", "cannot assign a value to `x`"),
    ("p = s", "write a name after `s`"),
    ("s = 1.0", "cannot assign a value to `s`"),
    ("_a = 2.0", "cannot assign a value to `_a`"),
    ("for _fault in range(3): pass", "cannot assign a value to `_fault`"),
    ("for i in range(x): pass", "a loop must count to a constant"),
    ("for i in range(99999999999999999999): pass", "2147483648"),
    ("for i in range(0, 9, 0): pass", "its step must not be 0"),
    ("for i, j in range(3): pass", "count with one name"),
    ("for i in range(3): pass\nelse: a = 1.0", "`else` after a loop"),
    ("for i in range(3): a = 1.0\nb = a", "'a' does not have a value in every case"),
    ("if x > 0: a = 1.0\nb = a", "'a' does not have a value in every case: set it before this line"),
    ("b = GAIN\nGAIN = 2.0", "'GAIN' does not have a value in every case"),
    ("if p.side == 'middle': pass", "Side must be one of right, left, not 'middle'"),
    ("if p.side == 0: pass", "compare Side with the name of an option: right, left"),
    ("if x is v: pass", "this comparison is not allowed"),
    ("a = f'{x}'", "text in quotes is not allowed"),
    ("a = 'soft'", "can only be compared with a choice"),
    ("a = None", "only numbers are allowed here"),
    ("a = 1" + 400 * "0", "this number is too large"),
    ("a = x @ v", "this operator is not allowed"),
    ("a = ~x", "`~` is not allowed"),
    ("if (a := x) > 0: pass", "`:=` is not allowed"),
    ("a: float = 1.0", "a type is not allowed"),
    ("x", "this line has no effect"),
    ("a = open(x)", "'open' is not a function that a law can call"),
    ("a = x(1.0)", "'x' is not a function that a law can call"),
    ("min = 2.0\na = min(x, v)", "'min' is not a function that a law can call"),
    ("a = half(x, v)", "`half` must have 1 argument, not 2"),
    ("a = abs(x, v)", "`abs` must have 1 argument, not 2"),
    ("a = min(x)", "`min` must have 2 to 8 arguments, not 1"),
    ("a = math.atan2(x)", "`math.atan2` must have 2 arguments, not 1"),
    ("a = math.hypot(y=x)", "arguments in a law must be given in order"),
    ("a = float(x=1)", "arguments in a law must be given in order"),
    ("a = math.gamma(x)", "math.gamma is not in the law language"),
    ("a = math.nan", "`math` can be used here"),
    ("math = 2.0\na = math.sin(x)", "`math` here is not Python's module"),
    ("a = x.__class__", "only `p.name`, `s.name`, tables and `math` can be used here"),
    ("a = p.stiffness.real", "only `p.name`, `s.name`, tables and `math` can be used here"),
    ("a = p.__class__", "'p.__class__' is not a parameter"),
    ("a = s.__dict__", "'s.__dict__' is not a state"),
    ("a = (x).hex()", "this call is not allowed"),
    ("a = x[0]", "only `p.name`, `s.name`, tables and `math` can be used here"),
    ("a = p", "write a name after `p`"),
    ("del v", "`del` is not allowed"),
    ("global GAIN", "`global` is not allowed"),
    ("raise ValueError", "`raise` is not allowed"),
    ("assert x > 0", "`assert` is not allowed"),
    ("match x:\n    case 1: pass", "`match` is not allowed"),
    ("yield x", "this line has no effect"),
    ("a = yield x", "`yield` is not allowed"),
    ("return", "a law must return a force"),
]
BESIDE = "GAIN = 2.0\n\ndef half(a):\n    return 0.5 * a\n\ndef both(a):\n    return a, -a\n"
STATE = "{'last': 0.0, 'ring': (0.0, 0.0)}"


@pytest.mark.parametrize(("line", "sentence"), REFUSED, ids=[line[:24] for line, _ in REFUSED])
def test_forbidden_code_is_rejected_with_its_line(tmp_path, line, sentence):
    text = law_text("a0 = 1.0\n" + line + "\nreturn 0.0", STATE, BESIDE)
    first = (HEAD + text).splitlines().index("    a0 = 1.0") + 2
    last = first + line.count("\n")
    with pytest.raises(LawError) as error:
        environment(tmp_path, text)
    message = str(error.value)
    assert sentence in message
    assert first <= error.value.line <= last
    assert message.startswith(f"Line {error.value.line}: ")
    assert "\n" not in message


@pytest.mark.parametrize(
    "line",
    ["while x > 0: x = x - 1", "try: return 1.0\nexcept: pass", "with open('f') as f: pass", "class A: pass"],
)
def test_forbidden_code_is_reported_before_a_missing_force(tmp_path, line):
    with pytest.raises(LawError, match="is not allowed") as error:
        environment(tmp_path, law_text(line))
    assert error.value.line == HEAD.count("\n") + 4


@pytest.mark.parametrize(
    ("signature", "text"),
    [
        ("(p, s, x, v)", "must be (p, s, x, v, dt)"),
        ("(p, s, x, v, dt, *more)", "must be (p, s, x, v, dt)"),
        ("(p, s, x, v, /, dt)", "must be (p, s, x, v, dt)"),
        ("(p, s, x, v, dt=1e-3)", "must be (p, s, x, v, dt), without default values"),
    ],
)
def test_a_law_takes_its_five_arguments(tmp_path, signature, text):
    with pytest.raises(LawError, match=r"^Line 7: ") as error:
        environment(tmp_path, f"@law\ndef force{signature}:\n    return 0.0\n")
    assert text in str(error.value)


@pytest.mark.parametrize(
    ("helper", "text"),
    [
        ("def help(a, b, c=2.0):\n    return a", "`help` must have 2 to 3 arguments, not 1"),
        ("def help(a, b='soft'):\n    return a", "only numbers are allowed here"),
        ("def help(a, *b):\n    return a", "plain names, without `*`"),
        ("def help(_fault):\n    return 1.0", "plain names"),
        ("def help(a):\n    return help(a)", "`help` calls itself"),
        ("def other(a):\n    return help(a)\n\ndef help(a):\n    return other(a)", "calls itself"),
        ("def help(a):\n    a = 1.0", "`help` must return a number in every case"),
        ("def help(a):\n    return p.stiffness", "`p` can be used only in the law"),
        ("def keep(f):\n    return f\n\n@keep\ndef help(a):\n    return a", "must not have a decorator"),
        (
            "def help(a):\n    if a > 0:\n        return a, a\n    return a",
            "returns 2 values in one line and 1 here",
        ),
        ("from math import sin as help", "'help' is not a function that a law can call"),
        ("help = 2.0", "'help' is not a function that a law can call"),
    ],
)
def test_helpers_obey_the_same_language(tmp_path, helper, text):
    with pytest.raises(LawError) as error:
        environment(tmp_path, law_text("return help(x)", STATE, helper))
    assert text in str(error.value)
    assert error.value.line > 0


@pytest.mark.parametrize(
    "body", ["a = 1.0", "if x > 0.0:\n    return 1.0", "for i in range(3):\n    return 1.0"]
)
def test_a_law_returns_on_every_path(tmp_path, body):
    with pytest.raises(LawError, match=r"in every case: end the function with `return 0\.0`"):
        environment(tmp_path, law_text(body))


def test_math_has_to_be_imported(tmp_path):
    text = law_text("return math.sin(x)", beside="del math\n")
    with pytest.raises(LawError, match="write `import math` at the top"):
        environment(tmp_path, text)


def test_a_value_of_a_function_around_the_law_is_refused():
    gain = 2.0

    def force(p, s, x, v, dt):
        return gain * x

    with pytest.raises(LawError, match="'gain' is inside another function"):
        law(force).bind(PARAMETERS)


@pytest.mark.parametrize("what", [abs, 5, print, lambda p, s, x, v, dt: 0.0, str.upper])
def test_only_functions_of_a_file_are_accepted(what):
    with pytest.raises(LawError):
        Law(what).bind(PARAMETERS)


@pytest.mark.parametrize("start", ["soft", None, float("nan"), (), (1.0, "a"), ((1.0,),), {"a": 1}])
def test_state_starts_at_numbers(start):
    with pytest.raises(LawError, match="State 'last' must start with"):
        law(state={"last": start})(lambda p, s, x, v, dt: 0.0)


def test_a_law_may_have_a_large_state_and_many_parameters():
    with pytest.raises(LawError, match="at most 16 state values, not 17"):
        law(state={"ring": (0.0,) * 17})(lambda p, s, x, v, dt: 0.0)
    with pytest.raises(LawError, match="at most 32 parameters, not 33"):
        Law(lambda p, s, x, v, dt: 0.0).bind(PARAMETERS * 11)
