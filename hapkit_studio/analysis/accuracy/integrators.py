"""Integrators: how far each is from the true motion of an object, at every step from 0.125 to 4 ms."""

from collections.abc import Callable

from hapkit_studio import environments
from hapkit_studio.analysis.accuracy import motions
from hapkit_studio.analysis.accuracy.driving import samples
from hapkit_studio.analysis.accuracy.plan import Plan, Run, always, repeats
from hapkit_studio.analysis.accuracy.sheet import Default, Method, Scene
from hapkit_studio.dynamics.integrators import INTEGRATORS
from hapkit_studio.environments.pushed import LABELS

STEPS = (4e-3, 2e-3, 1e-3, 0.5e-3, 0.25e-3, 0.125e-3)
THIRD = "a third of the smallest change of force that people feel, 6 %: an object's force follows its motion"
MOTIONS: dict[str, Callable[[], motions.Motion]] = {
    "free": motions.free,
    "damped": motions.damped,
    "driven": motions.driven,
    "contact": motions.contact,
    "stick_slip": motions.stick_slip,
}


def _default(environment: str) -> Default:
    """Return the integrator with which an environment starts."""
    found = environments.named(environment)
    choice = next(p for p in found.parameters if p.key == "integrator")
    return Default(choice.text(found.values()["integrator"]))


def _of_deflection(key: str, title: str, error: str, *conditions: tuple[str, str]) -> Scene:
    return Scene(key, title, error, 0.02, THIRD, _default("mass_spring_damper"), conditions=conditions)


def _scenes() -> tuple[Scene, ...]:
    values = environments.named("mass_spring_damper").values()
    puck = environments.named("puck").values()
    mass = ("Mass", f"{values['mass']:g} kg")
    spring = ("Stiffness", f"{values['stiffness']:g} N/m")
    damper = ("Damping", f"{values['damping']:g} N·s/m")
    start = ("Start", "10 mm, at rest")
    closed = ("Reference", "closed form, 1 s")
    first = "largest error / first deflection"
    return (
        _of_deflection("free", "Free mass on a spring", first, mass, spring, start, closed),
        _of_deflection("damped", "Damped mass on a spring", first, mass, spring, damper, start, closed),
        _of_deflection(
            "driven", "Mass on a spring, stirred by the hand", "largest error / largest deflection",
            mass, spring, damper, ("Contact", f"{values['contact_stiffness']:g} N/m"),
            ("Handle", "±5 mm at 2 Hz, known at samples"), closed,
        ),
        Scene(
            "contact", "Puck between two walls", "largest error / way between the walls", 0.02, THIRD,
            _default("puck"),
            conditions=(
                ("Mass", f"{puck['mass']:g} kg"), ("Walls", f"{puck['wall_stiffness']:g} N/m, 70 mm apart"),
                ("Start", f"{motions.SHOVED:g} m/s"), ("Reference", "closed form, 2 s"),
            ),
        ),
        Scene(
            "stick_slip", "Stick-slip", "error of the period / period", 0.02,
            "a third of the smallest change of force that people feel, 6 %: a period is the time of a pull",
            _default("puck"),
            conditions=(
                ("Mass", "0.05 kg"), ("Spring", "300 N/m, drawn at 2 cm/s"), ("Friction", "1 N, then 0.5 N"),
                ("Reference", "closed form, 3 s"),
            ),
        ),
    )  # fmt: skip


def runs(scene: Scene) -> list[Run]:
    """Return every integrator at every step."""
    motion = MOTIONS[scene.key]()
    found = []
    for number, (key, label) in enumerate(zip(INTEGRATORS, LABELS, strict=True)):
        for h in STEPS:
            times = repeats(samples(motion.seconds, h).size)
            work, _ = motion.computed(number, h, times)
            error = motion.error(number, h)
            found.append(Run(key, label, h, error, always(work), times * motion.seconds))
    return found


PLAN = Plan(
    "integrators",
    "Integrators",
    tuple(Method(key, label) for key, label in zip(INTEGRATORS, LABELS, strict=True)),
    _scenes(),
    runs,
    order=10,
)
