"""Start the installed window and visit every environment; print the results as JSON.

Run by path with ``python -I``, so that only installed modules can be imported.
"""

import json
import sys
import time
from pathlib import Path

from PySide6.QtWidgets import QApplication

import hapkit_studio
from hapkit_studio import resources
from hapkit_studio.arguments import window_parser
from hapkit_studio.gui.shell import app
from hapkit_studio.haptics import rows

PATIENCE = 180.0
"""s, time-out of each wait."""


def main(folder: Path) -> None:
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
        wait(lambda: window.studio.environment.key == key)  # its law may need to be compiled
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

    seen = {"package": hapkit_studio.__file__, "assets": str(resources.path())}
    seen["found"] = wait(lambda: window.live.last is not None)
    seen["visits"] = {key: visit(key) for key in window.studio.environments}
    window.close()
    print(json.dumps(seen))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
