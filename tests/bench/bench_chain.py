"""Time of judging every scene's ways to render it, and of a live answer to a slider."""

import statistics
import time

from hapkit_studio import environments
from hapkit_studio.analysis import chain
from tests.bench.frame import Row

NAME, ORDER = "chain", 33
ALL, LIVE = 180.0, 0.100  # s
SLIDES = 20


def run() -> list[Row]:
    """Return the seconds of all scenes, and the slowest scene's median of twenty slider steps."""
    questions = [chain.Question(e, e.values()) for e in environments.discover().values()]
    chain.in_force(questions[0])  # compiles
    begin = time.perf_counter()
    for question in questions:
        chain.compute(question)
    every = time.perf_counter() - begin
    slowest, scene = max((live(q), q.environment.title) for q in questions if q.environment.parameters)
    return [
        Row("speed and accuracy of all scenes", every, "s", target=f"< {ALL:g} s", ok=every < ALL),
        Row(f"a live answer, {scene}", 1e3 * slowest, "ms", target="< 100 ms", ok=slowest < LIVE),
    ]


def live(question: chain.Question) -> float:
    """Return the median time in s of an answer while a slider moves."""
    number = next(p for p in question.environment.parameters if not p.discrete)
    spent = []
    for step in range(SLIDES):
        value = number.default * (1.0 - 1e-3 * step)
        begin = time.perf_counter()
        chain.in_force(chain.Question(question.environment, {**question.values, number.key: value}))
        spent.append(time.perf_counter() - begin)
    return statistics.median(spent)
