"""Wide samples: `make test` looks into a few of their cases, `make test-all` into every one."""

from collections.abc import Callable, Iterable

import pytest


def wide(cases: Iterable, quick: Callable[..., object]) -> list:
    """Return cases, tuples where a test has several parameters; slow where quick(*case) does not hold."""
    given = [case if isinstance(case, tuple) else (case,) for case in cases]
    return [pytest.param(*case, marks=() if quick(*case) else pytest.mark.slow) for case in given]
