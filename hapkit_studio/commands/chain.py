"""The command that follows the chain from a scene's methods to the hand: tables, an object, a picture."""

import argparse
from functools import partial

from hapkit_studio import environments as library
from hapkit_studio.analysis import chain
from hapkit_studio.analysis.chain import Chain, Question
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
    """Follow the chain of every scene named; draw it where asked."""
    if options.parameter and len(options.environment) != 1:
        raise ParameterError("Parameters are of one environment: name it.")
    scenes = [base.environment_named(wanted, options.trust) for wanted in options.environment]
    given = base.key_values(options.parameter)
    questions = [Question(e, e.values(given)) for e in scenes or library.discover().values()]
    found = [chain.compute(q, base.progress_line(q.environment.key)) for q in questions]
    draw = partial(chain_figure, steps=len(found) == 1)
    text = "\n\n".join(map(_text, found))
    return base.with_files(
        text, {"scenes": [as_json(c) for c in found]}, base.drawn(options.plot, draw, found)
    )


def as_json(found: Chain) -> dict:
    """Return a scene as one object: a row a candidate, an answer a place."""
    question, answers = found.question, {}
    for place in question.places:
        answer = found.answer(place.name)
        answers[place.name] = {
            "cheapest_sufficient": answer.cheapest.row() if answer.cheapest else None,
            "as_cheap": [c.row() for c in answer.as_cheap],
            "default": answer.default.row() if answer.default else None,
            "reason": found.sentence(place.name),
        }
    rows = [c.row() for c in found.candidates]
    scene = {"scene": question.environment.key, "values": dict(question.values)}
    return {**scene, "rows": rows, "answers": answers, "refused": dict(found.refused)}


def _text(found: Chain) -> str:
    lines = [found.question.environment.title]
    for place in found.question.places:
        lines.append(f"{place.name.capitalize()}. {found.sentence(place.name)}")
        heads = "", "force mN", "a tick", "at most Hz", "Hz", "N/m", "felt"
        lines.append(f"  {heads[0]:<28}{heads[1]:>9}{heads[2]:>14}" + "".join(f"{h:>11}" for h in heads[3:]))
        for c in found.at(place.name):
            marks = ("* " if c.pareto else "  ") + ("default" if c is found.default(place.name) else "")
            cells = f"{c.fastest:>11,.0f}{c.rate:>11,.0f}{c.limit:>11,.0f}{chain.jnd(c.error):>11}"
            numbers = f"{1e3 * c.force_error:>9.1f}{chain.cost_words(c):>14}{cells}"
            lines.append(f"  {c.label:<28}{numbers} {marks}".rstrip())
    lines += found.refused.values()
    return "\n".join([*lines, "Nothing beats what is marked * in error and stiffness: the Pareto front."])


_HELP = "chart what each method's speed buys in stiffness, and what of its error is felt"
COMMAND = Command("chain", _HELP, run, OPTIONS, 61)
