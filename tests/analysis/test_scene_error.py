"""The error of a way to render: the puck by a loop in plain Python, Shapley values of known games."""

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.analysis import perception
from hapkit_studio.analysis.fidelity import script
from hapkit_studio.analysis.scene_error import COMPONENTS, IDEAL_RATE, SAMPLING, SceneError, Way, shapley
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.integrators import INTEGRATORS
from hapkit_studio.haptics import rows
from tests.wide import wide

HANDLE = SimulatedHapkit()
FINE = 32_000  # Hz of the plain loop's own steps
LIBRARY = environments.discover()


def scene_of(key, *hands):
    scene = LIBRARY[key]
    exact = {c.key: c.check(c.exact) for c in scene.parameters if getattr(c, "exact", None)}
    return SceneError(scene, scene.values(exact), HANDLE, hands)


def puck_in_plain_python(hand, rate=None, delay=0.0, verlet=False):
    """Return rows at perception.RATE of handle and puck; without a rate everything is continuous.

    Both move by steps of 1 / FINE: half a step, the force where they are then, half a step. A loop samples
    the handle, moves its puck by one step of the method, and its force acts a delay later.
    """
    trial = script(hand)
    gripped = trial.hand if trial.hand.release > 0.0 else None
    mass, damping, grip = HANDLE.mass, HANDLE.damping, 0.0
    if gripped:
        mass, damping, grip = mass + gripped.mass, damping + gripped.damping, gripped.stiffness
    count = round(trial.seconds * FINE)
    t = (np.arange(count + 1) + 0.5) / FINE
    target = gripped.target(t) if gripped else np.zeros(count + 1)
    moved = np.gradient(target, 1.0 / FINE)
    pull = (grip * target + (gripped.damping if gripped else 0.0) * moved).tolist()
    dry, h = HANDLE.coulomb_force / mass / FINE, 1.0 / FINE
    loss = 0.5 * h * damping / mass
    x, v, puck, u, motor, pending = 0.0, trial.thrown, 0.010, 0.0, 0.0, []
    before, side = 0.0, 1.0
    period = round(FINE / rate) if rate else 1
    late = round(delay * FINE)
    radius, reach, wall, contact, weight, quantum = 0.005, 0.035, 500.0, 500.0, 0.5, HANDLE.quantum

    def push(place, handle):
        """Return the handle's push on the puck; the handle stays on its side."""
        return contact * max(0.0, side * (handle + side * radius - place)) * side

    def pulled(place, handle):
        beyond = place - reach if place > reach else place + reach if place < -reach else 0.0
        return (push(place, handle) - wall * beyond) / weight

    places, speeds = [], []
    for n in range(count):
        places.append(x)
        speeds.append(v)
        if rate is None:
            x += 0.5 * h * v
            puck += 0.5 * h * u
            motor = -push(puck, x)
            u += h * pulled(puck, x)
            puck += 0.5 * h * u
        elif n % period == 0:
            seen, step = quantum * (x // quantum), period * h
            if n and verlet:
                now = pulled(puck, before)
                puck += step * u + 0.5 * step * step * now
                u += 0.5 * step * (now + pulled(puck, before))
            elif n:
                u += step * pulled(puck, before)
                puck += step * u
            if abs(seen - puck) >= radius:
                side = 1.0 if seen < puck else -1.0
            before = seen
            pending.append((n + late, min(max(-push(puck, seen), -HANDLE.max_force), HANDLE.max_force)))
        if rate is None and abs(x - puck) >= radius:
            side = 1.0 if x < puck else -1.0
        while pending and pending[0][0] <= n:
            motor = pending.pop(0)[1]
        if rate is not None:
            x += 0.5 * h * v
        w = (v * (1.0 - loss) + h * (pull[n] - grip * x + motor) / mass) / (1.0 + loss)
        v = w - dry if w > dry else w + dry if w < -dry else 0.0
        x += 0.5 * h * v
    found = np.zeros((round(trial.seconds * perception.RATE), rows.ROW_WIDTH))
    every = FINE // round(perception.RATE)
    found[:, rows.TRUE_POSITION] = places[::every][: len(found)]
    found[:, rows.TRUE_VELOCITY] = speeds[::every][: len(found)]
    if gripped:
        at = np.arange(len(found)) * every
        target, moved = gripped.target(t - 0.5 / FINE), np.gradient(gripped.target(t - 0.5 / FINE), h)
        found[:, rows.HAND_FORCE] = grip * (target[at] - found[:, rows.TRUE_POSITION])
        found[:, rows.HAND_FORCE] += gripped.damping * (moved[at] - found[:, rows.TRUE_VELOCITY])
    return trial.hand, found


@pytest.mark.parametrize("hand", ["tap", "shake", "released"])
@pytest.mark.parametrize(
    ("method", "rate", "delay"), [("semi_implicit", 2000.0, 0.279e-3), ("verlet", 1000.0, 0.386e-3)]
)
def test_the_puck_s_error_is_that_of_a_loop_in_plain_python(hand, method, rate, delay):
    values = LIBRARY["puck"].values({"integrator": method})
    found = scene_of("puck", hand).felt(Way(values, rate, delay, "kalman")).error
    holding, truth = puck_in_plain_python(hand)
    _, rendered = puck_in_plain_python(hand, rate, delay, verlet=method == "verlet")
    wanted = perception.difference_under(holding, truth, rendered).most
    assert found == pytest.approx(wanted, abs=0.15)  # 64 kHz is 0.08 JND from continuous


@pytest.mark.parametrize("key", wide(list(LIBRARY), lambda key: key in ("wall", "puck", "friction")))
def test_a_scene_itself_feels_the_same_at_twice_the_rate(key):
    scene = scene_of(key)
    assert scene.felt(Way(scene.exact, 2.0 * IDEAL_RATE, 0.0, "difference"), (SAMPLING,)).error < 0.05


@pytest.mark.parametrize(("key", "model"), [("friction", "tether"), ("friction", "coulomb")])
def test_the_parts_add_up_to_the_error(key, model):
    scene = scene_of(key, "pluck")
    way = Way(LIBRARY[key].values({"model": model}), 1000.0, 1e-3, "kalman")
    parts = scene.parts(way)
    assert set(parts) == set(COMPONENTS)
    assert sum(parts.values()) == pytest.approx(scene.felt(way).error, abs=1e-9)


def test_the_exact_method_and_a_force_limit_out_of_reach_have_no_part():
    parts = scene_of("puck", "tap").parts(Way(scene_of("puck").exact, 1000.0, 0.4e-3, "kalman"))
    assert INTEGRATORS[int(scene_of("puck").exact["integrator"])] == "exact"
    assert parts["method"] == parts["limit"] == parts["velocity"] == 0.0
    assert parts["rate"] > 0.0 < parts["delay"]


def test_the_values_of_games_that_are_known():
    """One left and two right gloves, of which a pair is worth 1; a runway that each needs to some length."""
    gloves = shapley(("l", "r", "s"), lambda some: float("l" in some and len(some) > 1))
    assert gloves == pytest.approx({"l": 2.0 / 3.0, "r": 1.0 / 6.0, "s": 1.0 / 6.0})
    lengths = {"a": 8.0, "b": 11.0, "c": 13.0, "d": 18.0}
    runway = shapley(tuple(lengths), lambda some: max((lengths[p] for p in some), default=0.0))
    assert runway == pytest.approx({"a": 2.0, "b": 3.0, "c": 4.0, "d": 9.0})


def test_values_add_up_a_dummy_has_none_and_equals_have_equal_ones():
    rng = np.random.default_rng(3)
    drawn = {}

    def worth(some):
        """Return a worth by lot that "idle" adds nothing to, and that treats "p" and "q" alike."""
        count, other = ("p" in some) + ("q" in some), "r" in some
        return drawn.setdefault((count, other), 0.0 if not (count or other) else rng.normal())

    players = ("p", "q", "r", "idle")
    found = shapley(players, worth)
    assert sum(found.values()) == pytest.approx(worth(players), abs=1e-12)
    assert found["idle"] == pytest.approx(0.0, abs=1e-12)
    assert found["p"] == pytest.approx(found["q"], abs=1e-12)
