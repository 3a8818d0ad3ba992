"""Time of one verdict on a scene; and a figure of eight scenes with verdict and motion of the handle."""

import statistics
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.stability.verdict import VerdictInput, verdict
from hapkit_studio.charts import style
from hapkit_studio.dynamics.hand import Hand, grip_named
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.haptics import headless, rows
from tests.bench.frame import Row

NAME, ORDER = "verdict", 31
LATE = 1e-3
# stiffness of a spring in N/m at 1 kHz and 1 ms delay, whose limit is 334 N/m
STIFFNESS = {"calm": 100.0, "near the limit": 320.0, "above": 500.0, "buzzing": 1800.0}
PUSHES = (0.5e-3, 6e-3)  # in m, below and above the boundary at 500 N/m


def scenes() -> dict[str, tuple[VerdictInput, str]]:
    """Return eight scenes, with or without friction, held or released; each has a hand for the drawing."""
    spring, found = environments.named("spring"), {}
    for name, stiffness in STIFFNESS.items():
        for friction, hand in ((True, "released"), (name in ("calm", "above"), "light")):
            setting = LoopSettings(delay=LATE, hand=hand, coulomb=LoopSettings.coulomb if friction else 0.0)
            what = f"{name}, {stiffness:,.0f} N/m, {'held lightly' if hand == 'light' else 'let go'}"
            text = what if friction else f"{what}, no dry friction"
            found[text] = VerdictInput(spring, spring.values({"stiffness": stiffness}), setting), hand
    return found


def motion(asked: VerdictInput, push: float) -> np.ndarray:
    """Return the positions (n,) in m of a handle released at rest ``push`` m away, in the setting's hand."""
    scene, grip = asked.scene, grip_named(asked.setting.hand)
    scene = replace(scene, device=replace(scene.device, initial_position=push))
    hand = Hand(grip.mass, grip.damping, grip.stiffness) if grip else None
    return headless.render(scene, hand, round(1.5 * scene.loop.rate))[0][:, rows.TRUE_POSITION]


def draw(path: Path, mode: str) -> None:
    """Draw the eight scenes, each with a push of 0.5 mm and one of 6 mm."""
    figure, c = style.new_figure(path, (13.0, 7.0)), style.colors(mode)
    for axes, (what, (asked, hand)) in zip(figure.subplots(2, 4).T.ravel(), scenes().items(), strict=True):
        style.style_axes(axes, c, "s", "mm")
        for push, color in zip(PUSHES, (c.position, c.applied), strict=True):
            place = motion(asked, push)
            axes.plot(np.arange(len(place)) / asked.setting.rate, 1e3 * place, color=color, linewidth=1)
        axes.set_ylim(-12.0, 12.0)
        does = verdict(asked).does[hand]
        title = [*what.split(", ", 1), does.sentence(hand != "released")]
        axes.set_title("\n".join(filter(None, title)), size=9, color=c.ink, loc="left")
    figure.savefig(path, dpi=100, facecolor=c.surface)


def seconds(asked: VerdictInput) -> float:
    """Return the time of one verdict in s."""
    start = time.perf_counter()
    verdict(asked)
    return time.perf_counter() - start


def run(pictures: Path | None = None) -> list[Row]:
    """Return the median time of twenty verdicts on each scene; draw them if a folder is given."""
    for mode in ("light", "dark") if pictures else ():
        draw(pictures / f"verdict-{mode}.png", mode)
    slowest = max(statistics.median(seconds(asked) for _ in range(20)) for asked, _ in scenes().values())
    return [
        Row(
            "verdict on a scene, the slowest of eight",
            1e3 * slowest,
            "ms",
            target="< 20 ms",
            ok=slowest < 0.02,
        )
    ]
