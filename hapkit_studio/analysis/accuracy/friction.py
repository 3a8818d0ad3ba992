"""Friction models: how true they make stick-slip, and how well what rests under a trembling pull holds.

Two scenes are a virtual mass alone, whose pull is known: there the default is projection, as in every
integrator of a moving mass. In the third the friction environment's law renders its models on a handle, by
the loop's own tick, and its default is judged.
"""

from hapkit_studio import environments
from hapkit_studio.analysis.accuracy import handle
from hapkit_studio.analysis.accuracy.plan import Plan, Run, always, repeats
from hapkit_studio.analysis.accuracy.sheet import Default, Method, Scene
from hapkit_studio.analysis.accuracy.sliders import HELD_SECONDS, Trial
from hapkit_studio.dynamics.stick_slip import MODELS
from hapkit_studio.environments.friction import MODELS as RENDERED

STEPS = (4e-3, 2e-3, 1e-3, 0.5e-3, 0.2e-3, 0.1e-3)
LABELS = {
    "coulomb": "Coulomb",
    "smoothed": "Smoothed",
    "karnopp": "Karnopp",
    "karnopp_band": "Karnopp’s band",
    "stribeck": "Stribeck",
    "projection": "Projection",
    "tether": "Tether",
    "lugre": "LuGre",
    "dahl": "Dahl",
    "hayward_armstrong": "Hayward–Armstrong",
}
VIRTUAL = Default("projection")


def _rendered() -> Default:
    found = environments.named("friction")
    choice = next(p for p in found.parameters if p.key == "model")
    return Default(choice.text(found.values()["model"]))


def _alone(trial: Trial) -> Run:
    times = repeats(round(trial.seconds / trial.dt))
    work, seconds = trial.computed(times)[0], times * trial.seconds
    return Run(trial.model, LABELS[trial.model], trial.dt, trial.error(), always(work), seconds)


def _on_handle(model: str, dt: float) -> Run:
    times, error = repeats(round(HELD_SECONDS / dt)), handle.error(model, dt)
    seconds = times * HELD_SECONDS
    return Run(model, LABELS[model], dt, error, lambda: handle.prepared(model, dt, times), seconds)


def _row(run: Run, scene: str) -> Run:
    """Return the run with its error under the name that says what it is."""
    name = "period_error" if scene == "period" else "drift_m_per_s"
    return Run(**{**vars(run), "extra": ((name, run.error),)})


def runs(scene: Scene) -> list[Run]:
    """Return every model at every step."""
    if scene.key == "handle":
        found = [_on_handle(model, dt) for model in RENDERED for dt in STEPS]
    else:
        found = [_alone(Trial(model, dt, scene.key == "hold")) for model in MODELS for dt in STEPS]
    return [_row(run, scene.key) for run in found]


def _scenes() -> tuple[Scene, ...]:
    resting = "less than a count of the Hapkit's sensor, 20.7 µm, in the two seconds: it rests"
    pull = ("Pull", "0.3 N ± 0.15 N at 20 Hz")
    mass = ("Mass", "0.05 kg")
    friction = ("Friction", "1 N, then 0.5 N")
    held, drift = ("Reference", "no drift"), "drift of what should hold"
    return (
        Scene(
            "period", "Stick-slip of a mass", "error of the period / period", 0.02,
            "a third of the smallest change of force that people feel, 6 %: a period is the time of a pull",
            VIRTUAL,
            conditions=(mass, ("Spring", "300 N/m, drawn at 2 cm/s"), friction, ("Reference", "closed form")),
        ),
        Scene(
            "hold", "A mass that should hold", drift, 1e-5, resting, VIRTUAL, "m/s",
            (mass, pull, friction, held),
        ),
        Scene(
            "handle", "A handle that should hold", drift, 1e-5, resting, _rendered(), "m/s",
            (
                ("Handle", "0.044 kg, 0.5 N·s/m"), ("Sensor", "20.7 µm"), pull, friction, held,
            ),
        ),
    )  # fmt: skip


PLAN = Plan(
    "friction",
    "Friction",
    tuple(Method(key, LABELS[key]) for key in MODELS),
    _scenes(),
    runs,
    order=40,
)
