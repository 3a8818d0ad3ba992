"""Time of the window's frames: five curves and the scene, 60 s of history at 4 kHz, at 60 fps.

It prints one JSON object, with pyqtgraph's own curves and peak downsampling as reference.
"""

import json
import sys
import time

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEventLoop, Qt, QTimer
from PySide6.QtWidgets import QApplication, QGridLayout, QWidget

from hapkit_studio import environments
from hapkit_studio.gui.live.history import LiveHistory
from hapkit_studio.gui.live.phase_plot import ForcePosition
from hapkit_studio.gui.live.time_plots import TimePlots
from hapkit_studio.gui.scenes import SceneView
from hapkit_studio.haptics import rows

RATE, SPAN, FRAME = 4000.0, 60.0, 1.0 / 60.0


def telemetry(first: int, count: int) -> np.ndarray:
    """Return rows of a hand that moves in and out of a noisy wall."""
    tick = first + np.arange(count)
    table = np.zeros((count, rows.ROW_WIDTH))
    table[:, rows.TICK], table[:, rows.HOST_TIME] = tick, tick / RATE
    time_s, noise = tick / RATE, np.sin(tick * 12.9898) * 43758.5453 % 1.0
    position = 0.02 * np.sin(2.0 * time_s) + 2e-4 * noise
    table[:, rows.POSITION] = position
    table[:, rows.VELOCITY] = 0.04 * np.cos(2.0 * time_s) + 0.02 * noise
    table[:, rows.FORCE] = -400.0 * np.maximum(position - 0.005, 0.0) * (1.0 + 0.2 * noise)
    table[:, rows.APPLIED_FORCE] = np.clip(table[:, rows.FORCE], -3.0, 3.0)
    return table


class Ours:
    """The plots and the scene drawn by the studio's own widgets."""

    def __init__(self, grid: QGridLayout):
        self.history = LiveHistory(SPAN)
        wall = environments.named("wall")
        self.times = TimePlots()
        self.phase = ForcePosition(self.times.cursors)
        grid.addWidget(self.times, 1, 0)
        grid.addWidget(self.phase, 1, 1)
        for plots in (self.times, self.phase):
            plots.view.set_history(self.history)
            plots.set_environment(wall, wall.values(), 3.0)
        self.times.view.set_span(SPAN)

    def frame(self, new: np.ndarray) -> None:
        self.history.append(new)
        self.times.refresh()
        self.phase.refresh()


class Reference:
    """The same minute drawn by pyqtgraph's curves, which process it again in every frame."""

    def __init__(self, grid: QGridLayout):
        self.data, self.end = np.zeros((rows.FLAGS, int(4 * SPAN * RATE))), 0
        column, self.curves = QGridLayout(), []
        grid.addLayout(column, 1, 0)
        for channels in ((rows.POSITION,), (rows.VELOCITY,), (rows.FORCE, rows.APPLIED_FORCE)):
            plot = pg.PlotWidget()
            plot.setDownsampling(auto=True, mode="peak")
            plot.setClipToView(True)
            plot.setXRange(-SPAN, 0.0)
            column.addWidget(plot)
            self.curves += [(plot.plot(skipFiniteCheck=True), rows.HOST_TIME, c) for c in channels]
        phase = pg.PlotWidget()
        grid.addWidget(phase, 1, 1)
        self.curves.append((phase.plot(skipFiniteCheck=True), rows.POSITION, rows.APPLIED_FORCE))

    def frame(self, new: np.ndarray) -> None:
        self.data[:, self.end : self.end + len(new)] = new[:, : rows.FLAGS].T
        self.end += len(new)
        for curve, across, up in self.curves:
            seconds = 10.0 if across == rows.POSITION else SPAN
            part = self.data[:, max(self.end - int(seconds * RATE), 0) : self.end]
            zero = part[across, -1] if across == rows.HOST_TIME else 0.0
            curve.setData(part[across] - zero, part[up])


def measure(kind: type, seconds: float) -> dict[str, float]:
    """Return frames per second and the GUI thread's share of a core, at an intended 60 frames per second."""
    window = QWidget()
    grid = QGridLayout(window)
    scene, wall = SceneView(), environments.named("wall")
    scene.set_environment(wall, wall.values())
    scene.setFixedHeight(236)
    grid.addWidget(scene, 0, 0, 1, 2)
    plots = kind(grid)
    grid.setColumnStretch(0, 1)
    grid.setColumnMinimumWidth(1, 348)
    window.resize(912, 784)  # this is the size of the central area in a window of 1440 × 900
    window.show()
    filled = int(SPAN * RATE)
    plots.frame(telemetry(0, filled))
    state = {"frames": 0}

    count = int(RATE * FRAME)
    to_come = [telemetry(filled + count * k, count) for k in range(int((seconds + 3.0) / FRAME))]

    def frame() -> None:
        new = to_come[state["frames"]]
        state["frames"] += 1
        plots.frame(new)
        row = new[-1]
        scene.update_state(
            row[rows.POSITION], row[rows.APPLIED_FORCE], row[rows.FORCE], 0.01, False, False, row[16:]
        )

    timer = QTimer()
    timer.setTimerType(Qt.TimerType.PreciseTimer)
    timer.timeout.connect(frame)
    loop = QEventLoop()
    timer.start(16)
    QTimer.singleShot(1000, loop.quit)
    loop.exec()
    before, cpu, wall_clock = state["frames"], time.thread_time(), time.perf_counter()
    QTimer.singleShot(int(1000 * seconds), loop.quit)
    loop.exec()
    timer.stop()
    elapsed = time.perf_counter() - wall_clock
    result = {
        "fps": (state["frames"] - before) / elapsed,
        "gui_thread_share": (time.thread_time() - cpu) / elapsed,
    }
    window.close()
    return {name: round(value, 3) for name, value in result.items()}


def main(seconds: float) -> None:
    """Measure both alternately, and print the results."""
    app = QApplication([])
    result = {"ours": measure(Ours, seconds), "pyqtgraph_peak": measure(Reference, seconds)}
    app.quit()
    print(json.dumps(result))


if __name__ == "__main__":
    main(float(sys.argv[1]))
