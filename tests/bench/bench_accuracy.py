"""Computing times of *Speed and accuracy*: all methods, all scenes, one scene, a live answer; its figures."""

import statistics
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

from hapkit_studio import environments
from hapkit_studio.analysis import accuracy
from hapkit_studio.analysis.accuracy import Accuracy, scene
from hapkit_studio.analysis.accuracy.scene import SceneRequest, SceneResult
from hapkit_studio.charts.accuracy import accuracy_figure
from hapkit_studio.parameters import Parameter
from tests.bench.frame import Row

NAME, ORDER = "accuracy", 45
LIVE, SLIDES = 0.050, 20  # LIVE: target of a live answer in s; SLIDES: number of slider values that are tried
# target of each computation in s
MOST = {"work-precision of all methods": 90.0, "all scenes in parts": 60.0, "the puck, not split": 1.0}


def run(folder: Path | None = None) -> list[Row]:
    """Return the times; if a folder is given, draw accuracy-<part>.png into it."""
    library, times = list(environments.discover().values()), [time.perf_counter()]
    questions = [SceneRequest(e, e.values()) for e in library]
    methods = accuracy.of_methods()
    times.append(time.perf_counter())
    scenes = accuracy.of_scenes(questions).scenes
    times.append(time.perf_counter())
    puck = next(s for s in scenes if s.question.environment.key == "puck")
    scene.compute(puck.question)
    times.append(time.perf_counter())
    slowest, title = max((live(s), s.question.environment.title) for s in scenes)
    for key in accuracy.plans() if folder else ():
        chosen = Accuracy(sheets=tuple(s for s in methods.sheets if s.chart == key))
        accuracy_figure(chosen, folder / f"accuracy-{key}.png")
    if folder:
        accuracy_figure(Accuracy(scenes=(puck,)), folder / "accuracy-scene.png")
        accuracy_figure(accuracy.of_needs(library), folder / "accuracy-needs.png")
    spent = [later - before for before, later in pairwise(times)]
    rows = zip(MOST.items(), spent, strict=True)
    found = [Row(name, s, "s", target=f"< {most:g} s", ok=s < most) for (name, most), s in rows]
    slowest_row = Row(f"a live answer, {title}", 1e3 * slowest, "ms", target="< 50 ms", ok=slowest < LIVE)
    return [*found, slowest_row]


def live(found: SceneResult) -> float:
    """Return the median processor time in s of a scene's new answer after a slider was moved."""
    question, times = found.question, []
    key = next((p.key for p in question.environment.parameters if isinstance(p, Parameter)), "")
    for n in range(SLIDES):
        moved = {key: (1.0 + 0.01 * n) * question.values[key]} if key else {}
        asked = replace(question, values={**question.values, **moved})
        begin = time.thread_time()
        scene.in_force(asked, found)
        times.append(time.thread_time() - begin)
    return statistics.median(times)
