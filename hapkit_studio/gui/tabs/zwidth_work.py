"""What the Z-width view lets a thread do: simulate the hits, or try walls on the engine that runs."""

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from hapkit_studio.gui.tabs.job import Progress, Work

if TYPE_CHECKING:
    from hapkit_studio.analysis.setting import Setting
    from hapkit_studio.analysis.zwidth_result import ZWidth
    from hapkit_studio.haptics.engine import Engine


class ZWidthWork(QObject):
    """Emits, from the thread at work, every point as it comes and what a person should do."""

    arrived = Signal(float, object)
    said = Signal(str)

    def simulation(self, setting: "Setting", max_force: float) -> Work:
        """Return work that simulates a setting with a motor's limit in N."""

        def work(progress: Progress) -> "ZWidth":
            from hapkit_studio.analysis import zwidth
            from hapkit_studio.analysis.zwidth_protocol import Protocol

            protocol = Protocol(max_force=max_force)
            return zwidth.compute(setting, protocol=protocol, progress=progress, arrived=self.arrived.emit)

        return work

    def device(self, engine: "Engine", max_force: float) -> Work:
        """Return work on a running engine, with a force limit in N."""

        def work(progress: Progress) -> "ZWidth":
            from hapkit_studio.analysis import zwidth_device
            from hapkit_studio.analysis.zwidth_bench import Care

            return zwidth_device.measure(
                engine,
                care=Care(max_force=max_force),
                progress=progress,
                arrived=self.arrived.emit,
                say=self.said.emit,
            )

        return work
