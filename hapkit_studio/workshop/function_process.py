"""The process that calls the functions of a user's file; its argument is the path of the file."""

import json
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hapkit_studio.environments.base import Conditions, Environment
from hapkit_studio.workshop import isolated, reading, source
from hapkit_studio.workshop.functions import CALL_SECONDS, GIVES, START_SECONDS


def main(path: str) -> None:
    """Execute the text that the first request contains, then call its functions on request.

    ``path`` is the path of the text's file. This process exits when the input ends.
    """
    requests, replies = isolated.take_pipes()
    isolated.limit_memory()
    try:
        isolated.exit_after(2 * START_SECONDS)
        environment = reading.execute(source.typed(Path(path), json.loads(requests.readline())))
        answer: Any = ""
        while True:
            replies.write(json.dumps(answer).encode() + b"\n")
            isolated.exit_after(None)
            request = json.loads(requests.readline())
            isolated.exit_after(2 * CALL_SECONDS)
            answer = _called(environment, *request)
    finally:
        os._exit(0)  # this is also reached if memory runs out or the parent has ended


def _called(environment: Environment, name: str, values: Mapping[str, float], *more: Any) -> Any:
    """Return a function's result for JSON; None if the function raises or returns a wrong type."""
    convert = GIVES[name][0]
    args = [Conditions(**m) if isinstance(m, dict) else np.array(m) for m in more]
    try:
        found = convert(getattr(environment, name)(values, *args))
    except MemoryError:
        raise
    except Exception:  # a user's function may raise anything
        return None
    return found.tolist() if isinstance(found, np.ndarray) else found


if __name__ == "__main__":
    main(sys.argv[1])
