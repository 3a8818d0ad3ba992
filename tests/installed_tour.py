"""Start the installed window and go through every environment; print what was seen as JSON.

Run by path with ``python -I``, so that only what is installed can be imported.
"""

import json
import sys
import time
from pathlib import Path

from PySide6.QtWidgets import QApplication

import hapkit_studio
from hapkit_studio import resources
from hapkit_studio.arguments import window_parser
from hapkit_studio.gui import app
from hapkit_studio.haptics import rows

PATIENCE = 60.0
"""s after which something is taken not to come any more."""


def wait(application, condition, seconds):
    end = time.perf_counter() + seconds
    while not condition() and time.perf_counter() < end:
        application.processEvents()
        time.sleep(1e-3)
    return condition()


def visit(application, window, key, folder):
    """Choose an environment, push into it for 200 rows, take a picture."""
    window.studio.choose(key)
    # its law may not be compiled yet
    wait(application, lambda: window.studio.environment.key == key, PATIENCE)
    window.studio.move_hand(0.012)
    window.live.tick()  # takes the rows from before
    first = window.live.last[rows.TICK]
    wait(application, lambda: window.live.last[rows.TICK] >= first + 200, PATIENCE)
    picture = folder / f"{key}.png"
    window.grab().save(str(picture))
    return {
        "chosen": window.studio.environment.key,
        "rows": window.live.last[rows.TICK] - first,
        "force": abs(window.live.last[rows.APPLIED]),
        "bytes": picture.stat().st_size,
        "running": window.studio.engine.health().running,
    }


def main():
    folder = Path(sys.argv[1])
    application = QApplication([])
    options = window_parser().parse_args([])
    window = app.build(options)
    window.show()
    app.begin(window, options)
    found = wait(application, lambda: window.live.last is not None, 180.0)
    seen = {
        "package": hapkit_studio.__file__,
        "assets": str(resources.path()),
        "found": found,
        "visits": {key: visit(application, window, key, folder) for key in window.studio.environments},
    }
    window.close()
    print(json.dumps(seen))


if __name__ == "__main__":
    main()
