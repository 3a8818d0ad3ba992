"""The command for speed and accuracy: tables of the ways to render a scene, an object, a picture."""

import argparse

from hapkit_studio import environments as library
from hapkit_studio.analysis import chain
from hapkit_studio.analysis.chain import Chain, Question
from hapkit_studio.analysis.scene_error import COMPONENTS
from hapkit_studio.charts.chain import chain_figure
from hapkit_studio.commands import base
from hapkit_studio.commands.base import Command, Result, option
from hapkit_studio.errors import ParameterError

OPTIONS = (
    option("environment", nargs="*", metavar="ENV", help="keys or files; none: all"),
    base.PARAMETER,
    base.TRUST,
    base.PLOT,
)


def run(options: argparse.Namespace) -> Result:
    """Judge the ways to render every scene named; draw them where asked."""
    if options.parameter and len(options.environment) != 1:
        raise ParameterError("Parameters are of one environment: name it.")
    scenes = [base.environment_named(wanted, options.trust) for wanted in options.environment]
    given = base.key_values(options.parameter)
    questions = [Question(e, e.values(given)) for e in scenes or library.discover().values()]
    found = [chain.compute(q, base.progress_line(q.environment.key)) for q in questions]
    text = "\n\n".join(map(_text, found))
    return base.with_files(
        text, {"scenes": [as_json(c) for c in found]}, base.drawn(options.plot, chain_figure, found)
    )


def as_json(found: Chain) -> dict:
    """Return a scene as one object: a row for each candidate, a recommendation for each place."""
    question, answers = found.question, {}
    for place in question.places:
        answer, default = found.recommendation(place.name), found.default(place.name)
        answers[place.name] = {
            "recommended": answer.best.row() if answer.best else None,
            "stiff_enough": answer.margin,
            "default": default.row() if default else None,
            "sentences": [words for words in found.sentences(place.name) if words],
        }
    rows = [c.row() for c in found.candidates]
    scene = {"scene": question.environment.key, "values": dict(question.values)}
    return {**scene, "rows": rows, "recommendations": answers, "refused": dict(found.refused)}


def _text(found: Chain) -> str:
    lines = [found.question.environment.title]
    for place in found.question.places:
        first, why = found.sentences(place.name)
        lines += [words for words in (first, why) if words]
        best = found.recommendation(place.name).best
        heads = "Hz", "N/m", "JND", *COMPONENTS.values()
        lines.append(f"  {'':<30}{'a tick':>14}" + "".join(f"{h:>{_width(h)}}" for h in heads))
        for c in found.at(place.name):
            marks = "recommended" if c is best else "", "default" if c is found.default(place.name) else ""
            parts = [f"{c.parts[key]:.2f}" if key in c.parts else "" for key in COMPONENTS]
            cells = f"{c.rate:,.0f}", f"{c.limit:,.0f}", chain.jnd(c.error).removesuffix(" JND"), *parts
            numbers = "".join(f"{t:>{_width(h)}}" for t, h in zip(cells, heads, strict=True))
            said = ", ".join(filter(None, marks))
            lines.append(f"  {c.label:<30}{chain.cost_words(c):>14}{numbers}  {said}".rstrip())
    lines += [f"{words}: {why}" if words else why for words, why in found.refused.items()]
    return "\n".join(lines)


def _width(head: str) -> int:
    return max(len(head) + 2, 8)


_HELP = "chart the error of each method in total and by component, with its rate and stiffness limit"
COMMAND = Command("speed-accuracy", _HELP, run, OPTIONS, 61, aliases=("chain",))
