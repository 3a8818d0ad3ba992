"""What Python calls invalid syntax is said as a beginner's mistake, wherever it is a common one."""

import pytest

from hapkit_studio.workshop import words

# (a text, the line that is wrong, what is said of it)
MISTAKES = [
    ("if x > 0 return 0.0\n", 1, "a colon is missing before `return`"),
    ("if p.side == 'a:b' return 0.0\n", 1, "a colon is missing before `return`"),
    ("else  # :\n    a = 1\n", 1, "a colon is missing after `else`"),
    ("if x > 0 and\n    a = 1\n", 1, "a colon is missing at the end of this line"),
    ("def f(x):\n    retrun x\n", 2, "'retrun' is no word of Python: perhaps `return`"),
    ("def f(x):\n    Return x\n", 2, "'Return' is no word of Python: perhaps `return`"),
    ("fi x > 0:\n    a = 1\n", 1, "'fi' is no word of Python: perhaps `if`"),
    ("fro i in range(3):\n    a = 1\n", 1, "'fro' is no word of Python: perhaps `for`"),
    ("form math import pi\n", 1, "'form' is no word of Python: perhaps `from`"),
    ("if a:\n    b = 1\nesle:\n    b = 2\n", 3, "'esle' is no word of Python: perhaps `else`"),
    ("if a:\n    b = 1\nelseif b:\n    b = 2\n", 3, "'elseif' is no word of Python: perhaps `elif`"),
    ("if x => 0:\n    a = 1\n", 1, "`=>` is not Python: write `>=`"),
    ("if x > 0 && x < 1:\n    a = 1\n", 1, "`&&` is not Python: write `and`"),
    ("if !x:\n    a = 1\n", 1, "`!` is not Python: write `not`"),
    ("x++\n", 1, "`++` is not Python: write `a = a + 1`"),
    ("if x > 0 then:\n    a = 1\n", 1, "`then` is not Python: the line ends with a colon"),
    ("if (x > 0:\n    a = 1\n", 1, "'(' is never closed"),
    ("for i in range(10:\n    a = 1\n", 1, "'(' is never closed"),
    ("a = f(1,\n    (2 +* (3,\n    4)))\n", 2, "Python cannot read this line from `*` on"),
    ("a = 2 x\n", 1, "between `2` and `x` a sign is missing, like `*`"),
    ("a = 1 +\nb = 2\n", 1, "something is missing at the end of this line"),
    ("lambda = 1\n", 1, "`lambda` is a word of Python: choose another name"),
    ("a = x return a\n", 1, "`return` begins a line of its own"),
    ("else:\n    a = 1\n", 1, "`else` stands below no `if` that begins as far to the right"),
    ("a = if x: 1\n", 1, "`if` is out of place"),
    ("a = 1 +* 2\n", 1, "Python cannot read this line from `*` on"),
    ("print 'a'\n", 1, "nothing can be printed here"),
    ("def f x:\n    return x\n", 1, "an opening bracket is missing after the name"),
]


@pytest.mark.parametrize(("text", "line", "said"), MISTAKES)
def test_a_common_mistake_is_named(text, line, said):
    with pytest.raises(SyntaxError) as caught:
        compile(text, "mine.py", "exec")
    found = words.of_syntax(caught.value, text.count("\n"))
    assert str(found) == f"Line {line}: {said}"


def test_a_line_of_which_nothing_is_known_is_still_named():
    error = SyntaxError("invalid syntax", ("mine.py", 3, None, None))
    assert str(words.of_syntax(error, 5)) == "Line 3: Python cannot read this line"
