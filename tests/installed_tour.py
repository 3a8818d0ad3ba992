"""Start the installed window and visit every environment; print the results as JSON.

With the word "all", also visit every view, play every lesson, and write, record and export an own law. Run it
by its path with ``python -I``, so that only installed modules can be imported; in a bundle use ``-m``.
"""

import json
import sys
import time
from pathlib import Path

from PySide6.QtWidgets import QApplication

import hapkit_studio
from hapkit_studio import api, cli, resources
from hapkit_studio.arguments import window_parser
from hapkit_studio.gui import pages
from hapkit_studio.gui.shell import app
from hapkit_studio.haptics import rows
from hapkit_studio.lessons import library
from hapkit_studio.sessions import folder as sessions
from hapkit_studio.workshop import folder as workshop
from hapkit_studio.workshop.source import read, trust_source

PATIENCE = 600.0
"""Time-out of each wait in s."""


def main(folder: Path, everything: bool = False) -> None:
    begin = time.perf_counter()
    application = QApplication([])
    options = window_parser().parse_args([])
    window = app.build(options)
    window.show()
    app.begin(window, options)

    def wait(condition):
        end = time.perf_counter() + PATIENCE
        while not condition() and time.perf_counter() < end:
            application.processEvents()
            time.sleep(1e-3)
        return condition()

    def visit(key):
        window.studio.choose(key)
        wait(lambda: window.studio.environment.key == key)  # the environment's law may need to be compiled
        window.studio.move_hand(0.012)
        window.live.tick()  # discard earlier rows
        first = window.live.last[rows.TICK]
        wait(lambda: window.live.last[rows.TICK] >= first + 200)
        picture = folder / f"{key}.png"
        window.grab().save(str(picture))
        return {
            "chosen": window.studio.environment.key,
            "rows": window.live.last[rows.TICK] - first,
            "force": abs(window.live.last[rows.APPLIED_FORCE]),
            "bytes": picture.stat().st_size,
            "running": window.studio.engine.health().running,
        }

    def show(key):
        window.views.show(key)
        application.processEvents()
        window.grab().save(str(folder / f"view-{key}.png"))
        return window.views.key == key and (window.views.shown is not None) == (key != "live")

    def own_law():
        """Record a new law; return the number of samples, largest force in N, file, and problems."""
        template = next(t for t in workshop.templates() if t.key == "spring")
        path = workshop.new_path("Our spring")
        workshop.save(path, workshop.fill_template(template, "Our spring", "our_spring"))
        trust_source(read(path))
        window.own.refresh()
        problems = []
        window.own.judged.connect(lambda _path, verdict: problems.extend(p.text for p in verdict.problems))
        window.own.choose(path)
        wait(lambda: window.studio.environment.title == "Our spring" or problems)
        recording = window.studio.recording
        recording.toggle()
        wait(lambda: recording.progress is not None)
        window.studio.move_hand(0.012)
        wait(lambda: recording.progress.seconds > 1.0)
        recording.toggle()
        wait(lambda: recording.progress is None)
        (session,) = sessions.files()
        run = api.open_session(session)
        run.save(str(folder / "own.csv"))
        run.plot(str(folder / "own.png"))
        return {
            "samples": len(run.time),
            "force": float(abs(run.force).max()),
            "session": str(session),
            "problems": problems,
        }

    seen = {"package": hapkit_studio.__file__, "assets": str(resources.path())}
    seen["found"] = wait(lambda: window.live.last is not None)
    seen["first_sample"] = time.perf_counter() - begin
    seen["visits"] = {key: visit(key) for key in window.studio.environments}
    if everything:
        seen["views"] = {key: show(key) for key in ("live", *pages.discover(), "live")}
        seen["own"] = own_law()
    window.close()
    if everything:
        seen["lessons"] = {
            key: cli.main(["lessons", "play", key, "--output", str(folder / f"{key}.hapkit")])
            for key in library().lessons
        }
    print(json.dumps(seen))


if __name__ == "__main__":
    main(Path(sys.argv[1]), "all" in sys.argv[2:])
