"""A map computed from a lattice of cells and the cells at boundaries equals the fully evaluated map."""

import numpy as np
import pytest
from scipy import ndimage

from hapkit_studio.analysis.stability import kb_plane, rendered
from hapkit_studio.analysis.stability.few_cells import STEP, from_few
from hapkit_studio.analysis.stability.rendered import GROWS
from hapkit_studio.dynamics.loop_settings import LoopSettings

ALL_AROUND = np.ones((3, 3))


def map_from_few_cells(full, seeds=()):
    """Return the map from a few cells of a full map, and how often each cell was evaluated, both (m, n)."""
    judged = np.zeros(full.shape, dtype=int)

    def judge(places):
        judged.ravel()[places] += 1
        return full.ravel()[places]

    return from_few(full.shape, judge, seeds), judged


def small_islands(full):
    """Return a mask (m, n) of the regions that contain no whole square of the lattice, and may be missed."""
    small = np.zeros(full.shape, dtype=bool)
    for one in np.unique(full):
        regions, _ = ndimage.label(full == one, ALL_AROUND)
        large = np.unique(regions[ndimage.binary_opening(full == one, np.ones((STEP, STEP)))])
        small |= (full == one) & ~np.isin(regions, large)
    return small


def drawn(rng, shape, smooth):
    """Return a random map of three classes; if ``smooth``, its regions are larger."""
    height = ndimage.gaussian_filter(rng.normal(size=shape), smooth)
    return np.searchsorted(np.quantile(height, [0.4, 0.7]), height).astype(np.int8)


@pytest.mark.parametrize("smooth", [3.0, 6.0, 20.0])
@pytest.mark.parametrize("shape", [(100, 100), (31, 140)])
def test_regions_larger_than_the_lattice_are_exact(rng, shape, smooth):
    for _ in range(8):
        full = drawn(rng, shape, smooth)
        found, judged = map_from_few_cells(full)
        wrong = found != full
        assert not (wrong & ~small_islands(full)).any()
        assert wrong.mean() < 0.03
        assert judged.max() == 1
        assert (found[judged > 0] == full[judged > 0]).all()


def few(full, judged):
    """Return True if, besides the lattice, at most three cells per boundary cell were evaluated."""
    beside = ndimage.maximum_filter(full, 3) != ndimage.minimum_filter(full, 3)
    return judged.sum() <= (full.shape[0] / STEP + 1.0) * (full.shape[1] / STEP + 1.0) + 3.0 * beside.sum()


def test_only_cells_along_a_boundary_are_evaluated():
    rows, columns = np.indices((100, 100))
    full = (rows > 50.0 + 30.0 * np.sin(0.06 * columns)).astype(np.int8)
    found, judged = map_from_few_cells(full)
    assert (found == full).all()
    assert few(full, judged)
    assert judged.sum() < 0.15 * full.size


def test_a_thin_strip_is_traced_from_one_cell():
    full = np.zeros((100, 100), dtype=np.int8)
    full[13:15, 12:88] = 2
    assert (map_from_few_cells(full)[0] == 0).all()
    found, judged = map_from_few_cells(full, [(14, 40)])
    assert (found == full).all()
    assert few(full, judged)


@pytest.mark.parametrize("shape", [(1, 100), (29, 29), (2, 3)])
def test_a_small_map_is_judged_cell_by_cell(rng, shape):
    full = rng.integers(0, 3, shape).astype(np.int8)
    found, judged = map_from_few_cells(full)
    assert (found == full).all()
    assert (judged == 1).all()


def every_cell(setting, damping, stiffness):
    k, b = (axis.ravel() for axis in np.meshgrid(stiffness, damping, indexing="ij"))
    what = rendered.rendered(setting, True)
    return rendered.judge(what, k, b).reshape(len(stiffness), len(damping))


@pytest.mark.slow
def test_a_strip_between_the_lattices_rows_is_found_by_the_exact_limits():
    """With a filter of 5 Hz, strong damping needs a stabilising stiffness of 320 to 1,580 N/m."""
    setting = LoopSettings(mass=0.05, viscous=1.0, coulomb=0.0, estimator=("butterworth", {"cutoff": 5.0}))
    damping, stiffness = np.linspace(7.5, 11.5, 32), 20.0 + 300.0 * np.arange(32)
    full = every_cell(setting, damping, stiffness)
    assert 0.02 < (full != GROWS).mean() < 0.15
    assert (full[[0, *range(6, 32)]] == GROWS).all()
    outcomes = []
    found = rendered.classes(
        setting, damping, stiffness, real=True, progress=lambda *now: outcomes.append(now)
    )
    assert (found == full).all()
    assert outcomes == sorted(outcomes)
    assert (outcomes[0], outcomes[-1]) == ((0, full.size), (full.size, full.size))


ESTIMATORS = ["difference", "iir", ("butterworth", {"cutoff": 60.0}), ("iir", {"cutoff": 100.0}), "kalman"]


def some_setting(rng, rates):
    rate = float(rng.choice(rates))
    return LoopSettings(
        mass=float(10 ** rng.uniform(-1.7, -0.7)),
        viscous=float(10 ** rng.uniform(-1.0, 0.5)),
        coulomb=float(rng.choice([0.02, 0.1, 0.3])),
        quantum=float(rng.choice([5e-6, 20.7e-6, 60e-6])),
        rate=rate,
        delay=float(rng.choice([0.0, 1.0, rng.uniform(0.0, 3.0)])) / rate,
        estimator=ESTIMATORS[rng.integers(len(ESTIMATORS))],
        hand=str(rng.choice(["released", "released", "light", "firm"])),
    )


@pytest.mark.parametrize(
    ("count", "side", "rates"),
    [(1, 32, [500.0]), pytest.param(20, 100, [500.0, 1000.0], marks=pytest.mark.slow)],
)
def test_a_rendered_map_equals_the_full_one_except_small_islands(rng, count, side, rates):
    shares = []
    for _ in range(count):
        setting = some_setting(rng, rates)
        plane = kb_plane.plane(setting, 100.0, 1.0, columns=2)
        damping, stiffness = (rendered.cell_centres(end, side) for end in (plane.width, plane.top))
        full = every_cell(setting, damping, stiffness)
        wrong = rendered.classes(setting, damping, stiffness, real=True) != full
        assert not (wrong & ~small_islands(full)).any(), setting
        shares.append(wrong.mean())
    assert max(shares) < 0.02
