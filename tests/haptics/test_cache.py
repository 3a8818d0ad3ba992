"""Every process but the first loads compiled code from the cache.

No law needs its own version of the loop.
"""

import json
import os
import subprocess
import sys

import pytest

PROCESS = """
import json, sys, time
import hapkit_studio as hs
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.haptics import headless, simulated_loop
from hapkit_studio.haptics.engine import Engine
from numba.core.dispatcher import Dispatcher

library = hs.environments()
for key in library:
    hs.simulate(key, seconds=0.02)
hs.simulate("wall", hand=hs.Prescribed(lambda t: 0.01), seconds=0.02)
engine = Engine(SimulatedHapkit(), realtime=False)
reader = engine.reader()
engine.start()
rows, deadline = {}, time.monotonic() + 200.0
for key in library:
    engine.set_environment(key)
    while rows.get(key, 0) < 20 and time.monotonic() < deadline:
        rows[key] = rows.get(key, 0) + len(reader.read())
        time.sleep(0.005)
engine.close()
missed = [
    f"{module.__name__}.{name}"
    for module in list(sys.modules.values())
    if getattr(module, "__name__", "").startswith(("hapkit_studio", "law_"))
    for name, value in vars(module).items()
    if isinstance(value, Dispatcher) and sum(value.stats.cache_misses.values())
]
batch, loop = headless.run_batch, simulated_loop.run
laws = [e.force.compiled().keepalive.law for e in library.values()]
print(json.dumps({
    "missed": sorted(set(missed)),
    "laws_compiled": [law.native_name for law in laws if not law.cache_hits],
    "addresses": len({law.address for law in laws}),
    "loops": [len(f.signatures) for f in (batch, headless.run_prescribed, loop)],
    "hits": sum(batch.stats.cache_hits.values()) + sum(loop.stats.cache_hits.values()),
    "rows": rows,
    "environments": len(library),
}))
"""


def process() -> dict:
    environment = {k: v for k, v in os.environ.items() if k != "NUMBA_DISABLE_JIT"}
    done = subprocess.run(
        [sys.executable, "-c", PROCESS],
        capture_output=True,
        text=True,
        timeout=240,
        env=environment,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


@pytest.mark.slow
def test_a_second_process_compiles_nothing_and_loops_have_one_signature_for_all_laws():
    process()
    second = process()
    assert second["missed"] == []
    assert second["laws_compiled"] == []
    assert second["hits"] == 2
    assert second["loops"] == [1, 1, 1]
    assert second["addresses"] == second["environments"] >= 4
    assert all(count >= 20 for count in second["rows"].values())
