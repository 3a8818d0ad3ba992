"""Environments whose laws are being compiled: they are marked, can be requested, and start when ready."""

import subprocess
import sys

import pytest
from PySide6.QtCore import Qt, QTimer
from PySide6.QtTest import QTest

from hapkit_studio.errors import LawError
from hapkit_studio.gui.shell import app
from hapkit_studio.gui.state import environment_library, prepare
from hapkit_studio.laws.law import Law
from tests.gui.own_support import put, spring, wait_for_verdict

READY = ("free", "spring", "wall")


class Compiler:
    """Substitute for the programs that compile: a law counts as compiled once it is in ``done``."""

    def __init__(self, window, monkeypatch):
        self.window = window
        self.done, self.looks, self.here = set(), [], []
        self.wrong: set[Law] = set()
        self.program = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE, stderr=-3)
        self._compiled = Law.compiled
        monkeypatch.setattr(Law, "is_compiled", lambda law: self._is_compiled(law))
        monkeypatch.setattr(Law, "compiled", lambda law: self._compile(law))
        self.finish(*READY)

    def _is_compiled(self, law: Law) -> bool:
        self.looks.append(law)
        return law in self.done

    def _compile(self, law: Law):
        if law in self.wrong:
            raise LawError("The law cannot be compiled: no such type")
        if law not in self.done:
            self.here.append(law)
        return self._compiled(law)

    def law(self, key: str) -> Law:
        return self.window.studio.environments[key].force

    def finish(self, *keys: str) -> None:
        laws = [self.law(key) for key in keys]
        self.done.update(laws, [law.companion for law in laws if law.companion is not None])

    def die(self) -> None:
        self.program.kill()
        self.program.wait()
        self.window.studio.readiness.refresh()


@pytest.fixture
def compiler(window, monkeypatch):
    """Return a substitute compiler for a window; three environments are ready."""
    made = Compiler(window, monkeypatch)
    window.studio.readiness.expect(window.studio.environments, ())
    window.studio.readiness.follow([made.program])
    yield made
    made.program.kill()
    made.program.wait()


@pytest.fixture
def forced(window):
    """Return a list that receives the key of every environment that becomes active."""
    keys: list[str] = []
    window.studio.environment_changed.connect(lambda: keys.append(window.studio.environment.key))
    return keys


def row_state(window, key):
    return window.gallery.rows[key].accessibleName().partition(": ")[2]


@pytest.mark.slow
def test_rows_show_which_environments_are_not_ready(window, compiler):
    assert {key for key in window.gallery.rows if row_state(window, key) != "Preparing…"} == set(READY)
    before = window.gallery.rows["puck"].grab().toImage()
    compiler.finish("puck")
    window.studio.readiness.refresh()
    assert row_state(window, "puck") == "A puck to push and catch"
    assert window.gallery.rows["puck"].grab().toImage() != before
    assert row_state(window, "cat") == "Preparing…"


def test_a_click_is_stored_and_nothing_is_compiled_in_the_window(window, compiler, forced, qtbot):
    QTest.mouseClick(window.gallery.rows["puck"], Qt.MouseButton.LeftButton)
    assert forced == []
    assert window.studio.environment.key == "wall"
    assert window.gallery.rows["wall"].isChecked()
    assert not window.gallery.rows["puck"].isChecked()
    assert row_state(window, "puck") == environment_library.WORDS["next"]
    compiler.finish("cat")
    window.studio.readiness.refresh()
    assert forced == []
    compiler.finish("puck")
    qtbot.waitUntil(lambda: forced == ["puck"])
    assert window.gallery.rows["puck"].isChecked()
    assert window.studio.engine.environment.key == "puck"
    assert compiler.here == []


def test_selecting_another_environment_cancels_the_request(window, compiler, forced):
    for other in ("spring", "wall", "cat"):  # the first is active, the second ready, the third not ready
        window.actions_by_key.run("environment.puck")
        window.actions_by_key.run(f"environment.{other}")
        assert row_state(window, "puck") == "Preparing…"
    compiler.finish("puck", "cat")
    window.studio.readiness.refresh()
    assert window.studio.environment.key == "cat"
    assert "puck" not in forced


@pytest.mark.slow
def test_selecting_an_own_environment_cancels_the_request(home, window, compiler, forced, qtbot):
    path = put(home, "mine.py", spring())
    window.own.refresh()
    window.studio.choose("puck")
    assert wait_for_verdict(window, qtbot, lambda: window.own.choose(path)).ok
    compiler.die()
    assert forced == ["test_spring"]
    assert window.studio.readiness.requested is None


@pytest.mark.slow
def test_polling_ends_when_everything_is_ready(window, compiler, qtbot):
    compiler.finish(*window.gallery.rows)
    qtbot.waitUntil(lambda: window.studio.readiness.waiting == ())
    compiler.looks.clear()
    qtbot.wait(4 * environment_library.POLL_MS)
    window.studio.choose("cat")
    assert window.studio.environment.key == "cat"
    assert compiler.looks == []
    assert not any(timer.isActive() for timer in window.studio.readiness.findChildren(QTimer))


def test_a_requested_law_is_compiled_in_the_window_if_the_programs_ended(window, compiler, forced):
    window.studio.choose("detents")
    compiler.die()
    assert forced == ["detents"]
    assert compiler.here[0] is compiler.law("detents")
    assert row_state(window, "puck") == "A puck to push and catch"
    assert compiler.law("puck") not in compiler.here


def test_a_law_that_cannot_be_compiled_gives_a_message(window, compiler, forced):
    compiler.wrong.add(compiler.law("detents"))
    compiler.die()
    for _ in range(2):
        QTest.mouseClick(window.gallery.rows["detents"], Qt.MouseButton.LeftButton)
        assert row_state(window, "detents") == "The law cannot be compiled"
        assert window.gallery.rows["wall"].isChecked()
    assert forced == []


def test_without_compiling_programs_every_environment_counts_as_ready(idle_window, monkeypatch):
    monkeypatch.setattr(Law, "is_compiled", lambda _law: False)
    monkeypatch.setattr(prepare, "_program", lambda *_, **_how: pytest.fail("A program was started."))
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    done = []
    app.prepare_all(idle_window, "wall", None, lambda: done.append(1))
    assert idle_window.studio.readiness.waiting == ()
    assert done == [1]


@pytest.mark.parametrize("compiles", [False, True])
def test_a_start_checks_the_other_laws_early_only_if_the_loop_is_compiled(
    idle_window, monkeypatch, qtbot, compiles
):
    looks, events = [], []
    monkeypatch.setattr(Law, "is_compiled", lambda law: looks.append(law))
    monkeypatch.setattr(prepare, "begin", lambda part, *_, **__: events.append(part))
    monkeypatch.setattr(prepare, "begin_laws", lambda keys: events.append("laws") or [])
    monkeypatch.setattr(app, "REST_MS", 1)
    program = subprocess.Popen([sys.executable, "-c", ""]) if compiles else None
    app.prepare_all(idle_window, "wall", program, lambda: events.append(("device", bool(looks))))
    qtbot.waitUntil(lambda: "analysis" in events)
    assert events == ["loop", ("device", compiles), "laws", "boards", "analysis"]
    others = [e.force for key, e in idle_window.studio.environments.items() if key not in READY]
    assert {*others} <= {*looks}
