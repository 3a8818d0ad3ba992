"""The former name of ``accuracy --needs``, kept for one release."""

from argparse import Namespace
from dataclasses import replace

from hapkit_studio.commands import accuracy
from hapkit_studio.commands.base import Result


def _run(options: Namespace) -> Result:
    return accuracy.run(Namespace(**{**vars(options), "needs": True}))


COMMAND = replace(
    accuracy.COMMAND, name="fidelity", help="former name of accuracy --needs", run=_run, order=201, aliases=()
)
