"""The table of all actions: key, text, shortcut, function and condition; it defines menus and shortcuts."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, cast

from hapkit_studio.environments.base import Environment
from hapkit_studio.gui import pages
from hapkit_studio.gui.editor.code_page import CYCLES, CYCLES_KEY
from hapkit_studio.gui.live.time_view import SPANS
from hapkit_studio.gui.shell import action_set
from hapkit_studio.gui.shell.window import TOUR, MainWindow
from hapkit_studio.gui.state.lock import DEVICE
from hapkit_studio.gui.state.permissions import POINTING, QUIZ
from hapkit_studio.gui.state.stored import StoredSettings
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.teach import demos
from hapkit_studio.gui.widgets.theme import theme

if TYPE_CHECKING:
    from hapkit_studio.gui.pages.accuracy import AccuracyPage
    from hapkit_studio.gui.pages.lessons.page import LessonsPage
    from hapkit_studio.gui.pages.sessions import SessionsPage

Action = action_set.Action[MainWindow]
THEMES = {
    "system": "Theme of the system",
    "light": "Light theme",
    "dark": "Dark theme",
    "contrast": "High-contrast theme",
}


def _has_engine(window: MainWindow) -> bool:
    return window.studio.engine is not None


def _has_board(window: MainWindow) -> bool:
    return window.studio.opened is not None and window.studio.opened.calibration


def _may_set_up(window: MainWindow) -> bool:
    return _has_board(window) and not window.studio.why_fixed(*DEVICE)


def _shows_values(window: MainWindow) -> bool:
    return not window.studio.hidden


def _replays(window: MainWindow) -> bool:
    return window.replay.history is not None


def _may_set(window: MainWindow) -> bool:
    return _shows_values(window) and not _replays(window)


def _has_parameters(window: MainWindow) -> bool:
    return bool(window.studio.environment.parameters)


def _has_samples(window: MainWindow) -> bool:
    return not window.centre.view.history.empty and _shows_values(window)


def _may_ask(window: MainWindow) -> bool:
    return not (window.demos.demo or window.projector.on) and window.quiz.parameter is not None


def _switch(window: MainWindow) -> None:
    if window.threshold.page is not None:
        window.threshold.page.turn()
    else:
        window.blind.step()


def _may_experiment(window: MainWindow) -> bool:
    return not (window.demos.demo or window.projector.on) and window.pointing.possible


def _has_law(window: MainWindow) -> bool:
    return window.editor.path is not None


def _demo(name: str, path: Path) -> Action:
    text = f"Demo: {demos.title(path)}"
    return Action(f"teach.demo.{name}", text, lambda w: w.play_demo(path), enabled=_may_play)


def _may_play(window: MainWindow) -> bool:
    studio = window.studio
    free = window.demos.possible and studio.fault is None and not _replays(window)
    return free and (not studio.stopped or studio.waits_for_render)


def table(environments: Iterable[Environment]) -> tuple[Action, ...]:
    """Return all actions, including one for each environment."""
    views = [("live", "Live"), *((tab.key, tab.title) for tab in pages.discover().values())]
    keys = [f"Ctrl+{place}" for place in range(1, 9)] + [""] * len(views)  # Ctrl+9 is the shortcut of the law
    tabs = [(key, title, shortcut) for (key, title), shortcut in zip(views, keys, strict=False)]
    laws = [(e.key, e.title, e.shortcut) for e in environments]
    return (
        *_SESSION,
        *_EDIT,
        *_one_of("view.tab", tabs, lambda w, key: w.views.show(key), lambda w: w.views.key),
        Action(
            "view.tab.law", "Law", lambda w: w.views.show("law"), "Ctrl+9",
            enabled=lambda w: w.views.has_law, checked=lambda w: w.views.key == "law",
        ),
        *_VIEW,
        *_DEVICE,
        *_one_of(
            "environment", laws, lambda w, key: w.studio.choose(key), lambda w: w.studio.environment.key
        ),
        *_ENVIRONMENT,
        *_CLASSROOM,
        *(_demo(name, path) for name, path in demos.shipped().items()),
        *_TEACH,
        *_HELP,
    )  # fmt: skip


def new_window(studio: Studio, settings: StoredSettings | None = None) -> MainWindow:
    """Return the main window with every action."""
    return MainWindow(studio, table(studio.environments.values()), settings)


def _one_of(
    prefix: str, options: Iterable[tuple[str, str, str]], choose: Callable[[MainWindow, str], object],
    chosen: Callable[[MainWindow], str], submenu: str = "",
) -> list[Action]:  # fmt: skip
    """Return one action per option (key, text, shortcut); exactly one of them is checked."""

    def option(key: str, text: str, shortcut: str) -> Action:
        run, checked = lambda w: choose(w, key), lambda w: chosen(w) == key
        exclusive = bool(submenu)
        return Action(
            f"{prefix}.{key}", text, run, shortcut, checked=checked, submenu=submenu, exclusive=exclusive
        )

    return [option(*given) for given in options]


def _sessions(window: MainWindow) -> "SessionsPage":
    """Show the view *Sessions*, unless the view cannot be changed now; return the page of this view."""
    window.views.show("sessions")
    return cast("SessionsPage", window.views.page("sessions"))


def _lists_sessions(window: MainWindow, button: str) -> bool:
    """Return whether the view *Sessions* is visible and its button with this name is enabled."""
    return window.views.key == "sessions" and getattr(window.views.shown, button).isEnabled()


_SESSION = (
    Action("session.stop", "E-stop", lambda w: w.studio.stop(), "Esc", filtered=True),
    Action(
        "session.release", "Release E-stop", lambda w: w.studio.release_stop(),
        enabled=lambda w: w.studio.stopped,
    ),
    Action(
        "session.clear_fault", "Clear fault", lambda w: w.studio.clear_fault(),
        enabled=lambda w: w.studio.fault is not None,
    ),
    Action(
        "session.pause", "Pause the picture", lambda w: w.live.toggle_paused(), "Space",
        checked=lambda w: w.live.paused,
    ),
    Action(
        "session.release_here", "Release handle here", lambda w: w.display.release_here(), "L",
        enabled=lambda w: w.studio.models_handle and not _replays(w),
    ),
    Action("session.open", "Open session…", lambda w: _sessions(w).ask_open(), "Ctrl+Shift+O", rule=True),
    Action(
        "session.rename", "Rename session…", lambda w: _sessions(w).ask_rename(), "F2",
        enabled=lambda w: _lists_sessions(w, "rename"),
    ),
    Action(
        "session.save_copy", "Save a copy of the session…", lambda w: _sessions(w).ask_copy(),
        enabled=lambda w: _lists_sessions(w, "copy"),
    ),
    Action(
        "session.review", "Review a handed-in lesson…", lambda w: _sessions(w).ask_review(),
        enabled=lambda w: _lists_sessions(w, "review"),
    ),
    Action("session.folder", "Choose the folder for recordings…", lambda w: _sessions(w).ask_folder()),
    Action(
        "session.record", "Record a session", lambda w: w.studio.recording.toggle(), "R",
        enabled=lambda w: w.studio.recording.possible,
        checked=lambda w: w.studio.recording.progress is not None, rule=True,
    ),
    Action(
        "session.save_kept", "Save the last 10 minutes", lambda w: w.studio.recording.save_buffer(),
        "Ctrl+Shift+S",
    ),
    Action(
        "session.marker", "Add a marker…", lambda w: w.show_marker(), "Ctrl+M",
        enabled=lambda w: _has_engine(w) and not _replays(w),
    ),
    Action(
        "session.step_back", "Replay: one frame back", lambda w: w.replay.step(-1), "Left", enabled=_replays,
        submenu="Replay",
    ),
    Action(
        "session.step_on", "Replay: one frame forward", lambda w: w.replay.step(1), "Right", enabled=_replays,
        submenu="Replay",
    ),
    Action(
        "session.sample_back", "Replay: one sample back", lambda w: w.replay.step(-1, sample=True),
        "Shift+Left", enabled=_replays, submenu="Replay",
    ),
    Action(
        "session.sample_on", "Replay: one sample forward", lambda w: w.replay.step(1, sample=True),
        "Shift+Right", enabled=_replays, submenu="Replay",
    ),
    Action(
        "session.close_replay", "Close the replay", lambda w: w.replay.close(), enabled=_replays,
        submenu="Replay",
    ),
    Action(
        "session.export", "Export visible samples…", lambda w: w.export.ask(w.export.visible), "Ctrl+Shift+E",
        enabled=_has_samples, submenu="Export",
    ),
    Action(
        "session.export_selection", "Export between the cursors…", lambda w: w.export.ask(w.export.selected),
        enabled=lambda w: w.centre.time.cursors.on and _has_samples(w), submenu="Export",
    ),
    Action(
        "session.export_kept", "Export the last minute…", lambda w: w.export.ask(),
        enabled=lambda w: _has_samples(w) and not _replays(w), submenu="Export",
    ),
    Action(
        "session.copy_picture", "Copy the plots as a picture", lambda w: w.copy_picture(), "Ctrl+Alt+C",
        enabled=lambda w: w.has_picture, submenu="Export",
    ),
    Action("session.quit", "Quit Hapkit Studio", lambda w: w.quit(), "Ctrl+Q", rule=True),
)  # fmt: skip


_EDIT = (
    Action(
        "edit.undo", "Undo", lambda w: w.history.undo(), "Ctrl+Z",
        enabled=lambda w: _may_set(w) and w.history.stack.canUndo(),
        current_text=lambda w: f"Undo {w.history.stack.undoText()}".rstrip(),
    ),
    Action(
        "edit.redo", "Redo", lambda w: w.history.redo(), "Ctrl+Shift+Z",
        enabled=lambda w: _may_set(w) and w.history.stack.canRedo(), extra=("Ctrl+Y",),
        current_text=lambda w: f"Redo {w.history.stack.redoText()}".rstrip(),
    ),
)  # fmt: skip


def _value(place: int, text: str, steps: int, key: str, *extra: str) -> Action:
    """Return an action that changes a value of the projector view by ``steps``; ``place`` is its index."""
    return Action(
        f"view.{text.lower().replace(' ', '_')}", text, lambda w: w.projector.card.step(place, steps), key,
        enabled=lambda w: w.projector.on, extra=extra, submenu="Values on projector",
    )  # fmt: skip


_PLOTS = (
    Action(
        "view.cursors",
        "Show cursors",
        lambda w: w.centre.toolbar.cursors.toggle(),
        checked=lambda w: w.centre.time.cursors.on,
    ),
    Action("view.cursor_a", "Put cursor A here", lambda w: w.centre.time.put_cursor(0), "A"),
    Action("view.cursor_b", "Put cursor B here", lambda w: w.centre.time.put_cursor(1), "B"),
    Action("view.hold", "Keep the curves", lambda w: w.display.keep_curves(), "H", enabled=_shows_values),
    Action("view.hold_file", "Compare with a recording…", lambda w: w.opener.ask(), enabled=_shows_values),
    Action(
        "view.live",
        "Back to the live plots",
        lambda w: w.display.go_live(),
        "Backspace",
        rule=True,
        on_plots=True,
    ),
    Action(
        "view.trigger",
        "Use the trigger",
        lambda w: w.centre.trigger.toggle(),
        "T",
        enabled=lambda w: not _replays(w),
        checked=lambda w: w.centre.trigger.armed,
        on_plots=True,
    ),
    Action("view.trigger_settings", "Trigger settings…", lambda w: w.show_trigger(), on_plots=True),
    Action(
        "view.lock",
        "Lock the axes",
        lambda w: w.centre.view.set_locked(not w.centre.view.locked),
        "Y",
        checked=lambda w: w.centre.view.locked,
        rule=True,
        on_plots=True,
    ),
    Action(
        "view.as_felt",
        "Plot the force as you feel it",
        lambda w: w.centre.phase.felt.toggle(),
        enabled=lambda w: w.centre.phase.felt.isEnabled(),
        checked=lambda w: w.centre.phase.felt.isChecked(),
    ),
    Action("view.fit", "Fit the axes", lambda w: w.fit_axes(), "F", on_plots=True),
    Action("view.grid", "Show grid", lambda w: w.toggle_grid(), "G", checked=lambda _w: theme.grid),
)


_VIEW = (
    *_one_of(
        "view.theme", [(mode, text, "") for mode, text in THEMES.items()],
        lambda w, mode: w.set_theme(mode), lambda _w: theme.mode, "Theme",
    ),
    *_one_of(
        "view.span", [(f"{s:g}", f"{s:g} s", "") for s in SPANS],
        lambda w, seconds: w.centre.view.set_span(float(seconds)), lambda w: f"{w.centre.view.span:g}",
        "Time window",
    ),
    *(replace(action, submenu="Plots") for action in _PLOTS),
    Action(
        "view.projector", "Projector view", lambda w: w.projector.toggle(), "F11", enabled=_shows_values,
        checked=lambda w: w.projector.on, rule=True,
    ),
    _value(0, "Increase the first projector value", 1, "+", "="),
    _value(0, "Decrease the first projector value", -1, "-"),
    _value(1, "Increase the second projector value", 1, "Ctrl++", "Ctrl+="),
    _value(1, "Decrease the second projector value", -1, "Ctrl+-"),
    Action(
        "view.panel", "Show panel", lambda w: w.toggle_panel(), "F4", enabled=_shows_values,
        checked=lambda w: w.panel_open,
    ),
    Action(
        "view.single_keys", "Use single-letter keys", lambda w: w.toggle_single_keys(),
        checked=lambda w: w.single_keys,
    ),
)  # fmt: skip


def _set_up(window: MainWindow) -> object:
    from hapkit_studio.gui.wizard.setup import SetupDialog

    return SetupDialog.open_over(window.studio, window, window.closed)


def _test(window: MainWindow) -> object:
    from hapkit_studio.gui.wizard.check import CheckDialog

    return CheckDialog.open_over(window.studio, window, window.closed)


_DEVICE = (
    Action("device.setup", "Set up my Hapkit…", _set_up, enabled=_may_set_up),
    Action("device.check", "Test my Hapkit…", _test, enabled=_has_board),
    Action("device.zero", "Set zero here", lambda w: w.studio.zero_here(), enabled=_may_set_up, rule=True),
    Action(
        "device.flip", "Reverse the handle's direction", lambda w: w.studio.flip_direction(),
        enabled=_may_set_up,
    ),
    Action(
        "device.reconnect", "Reconnect the device", lambda w: w.studio.device.reconnect(), "Ctrl+R",
        enabled=lambda w: w.studio.link.state not in ("preparing", "connecting"),
    ),
    Action("device.flash", "Flash firmware…", lambda w: w.show_flash()),
)  # fmt: skip


def _has_method(window: MainWindow) -> bool:
    if window.views.key != "accuracy":
        return False
    page = cast("AccuracyPage", window.views.shown)
    return page.part is page.scene and page.scene.use_button.isEnabled()


_ENVIRONMENT = (
    Action(
        "environment.reset", "Restore default values",
        lambda w: w.studio.reset_values(), enabled=_has_parameters,
        rule=True,
    ),
    Action(
        "environment.save_preset", "Save preset as…", lambda w: w.presets.ask_to_save(),
        enabled=_has_parameters, submenu="Presets",
    ),
    Action(
        "environment.compare_presets", "Compare presets…", lambda w: w.presets.ask_to_compare(),
        enabled=_has_parameters, submenu="Presets",
    ),
    Action(
        "environment.restore_preset", "Restore the values of the preset", lambda w: w.presets.restore(),
        enabled=lambda w: bool(w.presets.different), submenu="Presets",
    ),
    Action(
        "environment.use_method", "Use the recommended method",
        lambda w: cast("AccuracyPage", w.views.shown).scene.use(), enabled=_has_method,
    ),
    Action(
        "environment.import_preset", "Import preset…", lambda w: w.presets.bring(), submenu="Presets"
    ),
    Action("environment.new", "New environment…", lambda w: w.editor.begin_new(), "Ctrl+N", rule=True),
    Action("environment.open", "Open environment…", lambda w: w.file_actions.open(), "Ctrl+O"),
    Action("environment.export", "Export for Arduino…", lambda w: w.show_export()),
    Action(
        "environment.law", "Switch between law and scene", lambda w: w.views.toggle_law(), "Ctrl+E",
        enabled=lambda w: w.editor.path is not None or w.editor.own.active is not None,
    ),
    Action("environment.save", "Save law and run", lambda w: w.editor.save(), "Ctrl+S", enabled=_has_law),
    Action(
        "environment.cycles", CYCLES, lambda w: w.editor.page.count.toggle(), CYCLES_KEY, enabled=_has_law,
        checked=lambda w: w.editor.page.counting,
    ),
    Action("environment.close", "Close law", lambda w: w.editor.close(), "Ctrl+W", enabled=_has_law),
)  # fmt: skip


_CLASSROOM = (
    Action(
        "teach.switch", "Store settings A and B, then switch", _switch, "X",
        enabled=lambda w: _has_parameters(w) and w.studio.hidden not in (QUIZ, POINTING),
        current_text=lambda w: "Switch between A and B" if w.studio.hidden else w.two.next_text,
    ),
    Action(
        "teach.two_settings", "Compare settings A and B…", lambda w: w.blind.show_settings(),
        enabled=_shows_values,
    ),
    Action(
        "teach.lock", "Lock settings…", lambda w: w.show_lock(), enabled=_shows_values,
        current_text=lambda w: "Unlock settings…" if w.studio.permissions.lock.places else "Lock settings…",
    ),
    Action(
        "teach.blind", "Compare A and B blind", lambda w: w.blind.begin(),
        enabled=lambda w: _shows_values(w) and w.two.comparable,
    ),
    Action("teach.quiz", "Quiz: find the hidden value", lambda w: w.quiz.begin(), enabled=_may_ask),
    Action(
        "teach.threshold", "Experiment: just-noticeable difference…", lambda w: w.threshold.show_settings(),
        enabled=_may_experiment, rule=True,
    ),
    Action(
        "teach.pointing", "Experiment: pointing with friction…", lambda w: w.pointing.show_settings(),
        enabled=_may_experiment,
    ),
)  # fmt: skip


def _lesson(window: MainWindow) -> "LessonsPage | None":
    """Return the page with the open lesson; None if no lesson is open."""
    page = cast("LessonsPage | None", window.views.built("lessons"))
    return page if page is not None and page.stays else None


def _lesson_step(key: str, text: str, steps: int, shortcut: str) -> Action:
    def run(window: MainWindow) -> None:
        page = _lesson(window)
        if page is not None:
            page.go(steps)

    return Action(
        f"teach.lesson_{key}", text, run, shortcut, enabled=lambda w: _lesson(w) is not None, rule=steps > 0
    )


_TEACH = (
    Action("teach.open_demo", "Open demo…", lambda w: w.open_demo(), enabled=_may_play, rule=True),
    Action("teach.end_demo", "End demo", lambda w: w.demos.end(), enabled=lambda w: w.demos.demo is not None),
    _lesson_step("next", "Lesson: next step", 1, "Alt+Right"),
    _lesson_step("back", "Lesson: previous step", -1, "Alt+Left"),
)  # fmt: skip


_HELP = (
    Action("help.first_steps", "First steps: a tour of the window", lambda w: w.show_lesson(TOUR)),
    Action("help.lessons", "Lessons", lambda w: w.views.show("lessons"), "Ctrl+L"),
    Action("help.law", "Law language", lambda w: w.show_law_language()),
    Action("help.glossary", "Glossary", lambda w: w.show_help("glossary")),
    Action("help.troubleshooting", "Troubleshooting", lambda w: w.show_help("troubleshooting")),
    Action("help.write_lesson", "How to write lessons", lambda w: w.show_help("lessons")),
    Action("help.find", "Find a command…", lambda w: w.show_commands(), "Ctrl+K", rule=True),
    Action("help.keys", "Keys and glossary", lambda w: w.show_keys(), "F1", extra=("?",)),
    Action("help.priority", "Real-time priority", lambda w: w.show_priority(), enabled=_has_engine),
    Action("help.about", "About Hapkit Studio", lambda w: w.show_about(), rule=True),
)
