"""The Python examples of the documentation pages print the results shown there."""

import doctest
import re
from pathlib import Path

import pytest

from hapkit_studio import resources

PAGES = ("api.md", "tutorial.md")


def examples(page):
    """Return a page's fenced examples only, on their original lines."""
    text = resources.path("docs", page).read_text(encoding="utf-8")
    return re.sub(r"^```(python)?$", "", text, flags=re.MULTILINE)


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES)
def test_examples_of_a_page_give_the_printed_results(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = doctest.DocTestParser().get_doctest(examples(page), {}, page, page, 0)
    assert len(found.examples) > 20
    printed = []
    failed, _ = doctest.DocTestRunner(verbose=False).run(found, out=printed.append)
    assert failed == 0, "".join(printed)


def test_the_reference_describes_every_public_name_with_an_example():
    import hapkit_studio

    text = resources.path("docs", "api.md").read_text(encoding="utf-8")
    sections = dict(re.findall(r"^## (\w+)\n(.*?)(?=^## |\Z)", text, flags=re.MULTILINE | re.DOTALL))
    exceptions = {"LawError", "ParameterError", "StudioError"}
    others = {"__version__", "stable_stiffnesses"}
    assert set(sections) == set(hapkit_studio.__all__) - exceptions - others
    assert not [name for name, body in sections.items() if ">>>" not in body]
    assert not [name for name in exceptions if name not in text]


def test_how_it_works_names_existing_files_and_follows_each_path_through_at_most_five():
    text = resources.path("docs", "how-it-works.md").read_text(encoding="utf-8")
    root = Path(__file__).parents[1]
    firmware = {path.name for path in (root / "firmware" / "hapkit").iterdir()}
    named = set(re.findall(r"`([\w./-]+\.(?:py|cpp|h|S))`", text))
    assert len(named) > 50
    places = (root, root / "hapkit_studio")
    assert [
        n for n in sorted(named) if n not in firmware and not any((p / n).is_file() for p in places)
    ] == []
    paths = [line for line in text.splitlines() if re.match(r"\| an? [^|]+ \| `", line)]
    assert [line.count(".py`") for line in paths] == [5] * 5
