"""The library discovers environments by modules, and by the entry points of other packages."""

import re
from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path
from string import ascii_uppercase

import pytest

import hapkit_studio as hs
from hapkit_studio import discovery, environments
from hapkit_studio.environments import with_shortcuts
from hapkit_studio.errors import ParameterError
from tests.environments.calling import LIBRARY


def test_discovers_the_modules_of_its_folder():
    folder = environments.__path__[0]
    files = {path.stem for path in Path(folder).glob("*.py") if "\nENVIRONMENT = " in path.read_text("utf-8")}
    assert set(LIBRARY) == files
    assert hs.environments() == LIBRARY
    assert hs.environments is environments


def test_keys_shortcuts_and_titles_are_unique():
    for values in ([e.shortcut for e in LIBRARY.values() if e.shortcut], [e.title for e in LIBRARY.values()]):
        assert len(set(values)) == len(values)


def test_an_environment_without_a_shortcut_gets_a_free_letter():
    base = LIBRARY["free"]
    some = [replace(base, key=f"e{n}", title="Fabric", shortcut="") for n in range(30)]
    given = [e.shortcut for e in with_shortcuts([LIBRARY["cat"], *some])]
    assert given[:3] == ["C", "I", "D"]  # F, A, B and R are reserved for the window, and C is the cat's
    letters = [s for s in given if s]
    assert sorted(letters) == sorted(set(ascii_uppercase) - set("ABFGHLRT"))
    assert given[len(letters) :] == [""] * (31 - len(letters))


def test_an_unknown_environment_lists_the_known_ones():
    for wrong in ("wal", "", 5, None, ["wall"], {"wall"}):
        with pytest.raises(
            ParameterError, match=r"There is no environment .*; available: free, spring, wall"
        ):
            environments.named(wrong)


def test_a_broken_environment_of_another_package_is_skipped_with_a_warning(monkeypatch):
    broken = EntryPoint("torn", "no_such_module_anywhere:ENVIRONMENT", environments.ENTRY_POINTS)
    monkeypatch.setattr(discovery, "entry_points", lambda group: [broken])
    with pytest.warns(UserWarning, match="'torn'.*cannot be loaded.*no_such_module_anywhere"):
        found = environments.discover.__wrapped__()
    assert list(found) == list(LIBRARY)


@pytest.mark.parametrize("key", [key for key, environment in LIBRARY.items() if environment.symbols])
def test_each_symbol_of_a_formula_is_explained(key):
    """F is the force on the handle, and ẋ and ẍ are derivatives of x."""
    formula, symbols = (
        set("".join(re.findall(r"<i>(.*?)</i>", text.replace("&nbsp;", ""))).replace(" ", ""))
        for text in (LIBRARY[key].formula, LIBRARY[key].symbols)
    )
    assert formula - set("Fẋẍ") <= symbols
