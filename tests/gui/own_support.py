"""Support for tests of own environments: files, a temporary folder, waiting for a trial."""

from pathlib import Path

from hapkit_studio.workshop.source import read, trust_source
from tests.gui.window_support import PATIENCE_MS

SPRING = '''"""A spring of a test."""

from hapkit_studio.environments.base import Environment
from hapkit_studio.laws import law
from hapkit_studio.parameters import Parameter


@law
def force(p, s, x, v, dt):
    return -p.stiffness * x


ENVIRONMENT = Environment(
    key="{key}",
    title="{title}",
    summary="For a test",
    parameters=(Parameter("stiffness", "Stiffness", "N/m", 100.0, 0.0, 500.0),),
    force=force,
)
'''
LAW_LINE = 10


def spring(key: str = "test_spring", title: str = "Test spring", force: str = "-p.stiffness * x") -> str:
    """Return the text of a file whose law returns the expression ``force`` in line LAW_LINE."""
    return SPRING.format(key=key, title=title).replace("-p.stiffness * x", force)


def put(home: Path, name: str, text: str, trusted: bool = True) -> Path:
    """Write a file; if ``trusted``, the studio trusts it like a file that it has written itself."""
    path = home / "environments" / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    if trusted:
        trust_source(read(path))
    return path


def wait_for_verdict(window, qtbot, run):
    """Run a function that starts a trial; return the verdict."""
    with qtbot.waitSignal(window.own.judged, timeout=PATIENCE_MS) as heard:
        run()
    return heard.args[1]


def law_tab(window) -> str | None:
    """Return the text of the law's tab in the header; None without one."""
    tabs = window.header.tabs
    texts = [tabs.tabText(index) for index in range(tabs.count()) if tabs.tabData(index) == "law"]
    return texts[0] if texts else None
