"""Open the window like a user; print the times of its first frame, first plotted sample and last law."""

import gc
import json
import sys
import time

from hapkit_studio.arguments import window_parser
from hapkit_studio.gui.state import prepare

gc.disable()
OPTIONS = window_parser().parse_args([])
PREPARING = prepare.begin(
    "loop", OPTIONS.environment or prepare.FIRST
)  # the command starts compilation before it loads Qt

from PySide6.QtCore import QTimer  # noqa: E402
from PySide6.QtWidgets import QApplication, QLabel  # noqa: E402

from hapkit_studio.gui.shell import app  # noqa: E402

POLL_MS = 20


def main(everything: bool) -> None:
    """Print one JSON object: times in s of time.perf_counter, and the window's messages meanwhile.

    With ``everything``, wait until every environment is available.
    """
    application = QApplication(["bench"])
    window = app.build(OPTIONS)
    window.show()
    application.processEvents()
    gc.freeze()
    seen: dict[str, object] = {"window": time.perf_counter(), "notices": []}

    def read_labels() -> None:
        labels = [label.text() for label in window.findChildren(QLabel) if label.isVisible()]
        seen["notices"] = sorted({text for text in labels if "ompil" in text or "repar" in text})

    def plotted() -> None:
        application.processEvents()
        seen["sample"] = time.perf_counter()
        leave()

    def leave() -> None:
        if everything and window.studio.readiness.waiting:
            QTimer.singleShot(POLL_MS, leave)
            return
        seen["everything"] = time.perf_counter()
        print(json.dumps(seen), flush=True)
        window.close()

    def first(*_) -> None:
        window.live.frame.disconnect(first)
        QTimer.singleShot(0, plotted)

    window.live.frame.connect(first)
    QTimer.singleShot(300, read_labels)
    app.begin(window, OPTIONS, PREPARING)
    application.exec()


if __name__ == "__main__":
    main("everything" in sys.argv[1:])
