"""The plan for a law on a board contains the rate, or states that memory or time is insufficient."""

import math
import threading

import pytest

from hapkit_studio import environments
from hapkit_studio.environments.base import Environment
from hapkit_studio.haptics import link
from hapkit_studio.haptics.block_content import BlockContent
from hapkit_studio.haptics.board_plan import (
    CLOCK,
    RATES,
    BackgroundPlanner,
    BoardPlanner,
    PlanRequest,
    RenderingDecision,
    share,
)
from hapkit_studio.laws import law
from hapkit_studio.laws.machine import ESTIMATE, FRAME, REST, REST_AT_MOST
from hapkit_studio.protocol.framing import crc16
from hapkit_studio.protocol.messages import SettingsRequest
from tests.devices.fake_board import ARENA, KIT, FakeKit
from tests.haptics.support import CONSTANT
from tests.waiting import PATIENCE, wait_until
from tests.wide import wide

SPRING = environments.named("spring")


@law
def powers(p, s, x, v, dt):
    total = 0.0
    for i in range(8):
        total += (2.0 + x) ** (0.1 + v + i)
    return total


SLOW = Environment("slow", "Powers", "", (), powers)


def planner(arena=ARENA):
    return BoardPlanner(arena, KIT)


def request(environment=SPRING, rate=None, **values):
    return PlanRequest(environment, environment.values(values), rate=rate)


READING_VELOCITY = environments.discover().keys() - {"free", "bump_valley", "texture", "button"}


@pytest.mark.parametrize("key", wide(environments.discover(), lambda key: key in ("spring", "cat")))
def test_a_law_is_rendered_as_fast_as_its_cycles_allow(key):
    found = planner(4096).plan(request(environments.named(key)))
    estimate = ESTIMATE if key in READING_VELOCITY else 0
    usual, most = found.program.usual + REST + estimate, found.program.most + REST_AT_MOST
    frames = found.rate / math.ceil(found.rate / 1000.0)
    assert 500.0 <= frames <= 1000.0
    assert found.share == pytest.approx((found.rate * usual + frames * FRAME) / CLOCK)
    assert found.share <= 0.8
    assert most <= CLOCK / found.rate
    assert found.period == round(2e6 / min(RATES, key=lambda rate: abs(rate - found.rate)))
    for faster in (rate for rate in RATES if rate > found.rate + 50.0):
        assert share(found.program, faster) > 0.799 or most > 0.999 * CLOCK / faster


def test_a_requested_rate_can_only_reduce_the_rate():
    fastest = planner().plan(request()).rate
    assert planner().plan(request(rate=500)).rate == 500
    assert planner().plan(request(rate=4000)).rate == fastest


def test_a_law_that_is_too_long_is_refused_with_its_excess():
    size = planner().plan(request()).program.size
    assert not isinstance(planner(size).plan(request()), str)
    text = f"{SPRING.title} needs {size} bytes of memory, but the board has {size - 1}."
    assert planner(size - 1).plan(request()) == text


def test_a_law_that_is_too_slow_is_refused_with_its_fastest_rate():
    text = planner().plan(request(SLOW))
    assert text.startswith("One call of Powers takes ")
    assert " cycles of the board's processor. " in text
    assert text.endswith(" Hz at most, but the board's slowest rate is 500 Hz.")
    assert 0 < int(text.split("allows ")[1].split(" Hz")[0]) < 500


def test_the_plan_is_computed_once():
    made = planner()
    assert made.known(request()) is None
    found = made.plan(request())
    assert made.known(request()) is found
    assert made.known(request(stiffness=90.0)) is None
    assert made.known(request(rate=500)) is None
    for stiffness in range(100, 165):
        made.plan(request(stiffness=float(stiffness)))
    assert made.known(request()) is None  # old plans are discarded


def test_different_constants_of_the_same_code_keep_the_rate_while_they_fit():
    button = environments.named("button")
    made, numbers = planner(), [p for p in button.parameters if not p.discrete]
    first = made.plan(request(button))
    moved = made.plan(request(button, **{p.key: 0.9 * p.default + 0.1 * p.high for p in numbers}))
    assert moved.program.code == first.program.code
    assert moved.program.given != first.program.given
    assert moved.period == first.period
    assert moved.share <= 0.8


def test_different_constants_have_the_same_code_id():
    made = planner()
    first, stiffer = made.plan(request()), made.plan(request(stiffness=90.0))
    assert (stiffer.code_id, stiffer.program_id != first.program_id) == (first.code_id, True)
    others = (
        request(rate=500),
        request(environments.named("wall")),
        PlanRequest(SPRING, SPRING.values(), "kalman"),
    )
    assert len({made.plan(w).code_id for w in others} | {first.code_id}) == 4


def test_the_block_contains_the_data_to_send():
    way = planner().plan(request(CONSTANT))
    _, settings, program = BlockContent(
        CONSTANT, CONSTANT.values(), decision=RenderingDecision(in_force=way)
    ).encode()
    data = way.program.data
    assert program.astype("<i8").tobytes()[: len(data)] == data
    assert settings.board_form[link.CHECK] == crc16(data)
    assert settings.board_form[link.PERIOD] == way.period == round(2e6 / way.rate)
    assert settings.board_law == settings.law
    assert 4 * settings.board_form[link.CONSTANTS] + settings.board_form[link.CODE] == len(data)
    taken = 4 * way.program.slots + len(way.program.code) + 6 * settings.board_moving
    assert ARENA - 6 < taken <= ARENA


@pytest.mark.parametrize(
    ("kit", "text"),
    [
        (FakeKit(arena=0), "The firmware on this board cannot render laws. Update the firmware."),
        (FakeKit(deaf={SettingsRequest: 99}), "did not answer"),
    ],
)
def test_a_device_without_a_board_gives_the_reason(stepped, kit, text):
    engine = stepped(kit)[1]
    assert text in engine.decision().refusal
    assert engine.where == "computer"


def test_a_defect_of_the_compiler_is_an_answer_and_the_thread_ends(monkeypatch):
    def fail(self, request):
        raise ZeroDivisionError("a defect")

    monkeypatch.setattr(BoardPlanner, "_work_out", fail)
    answered = threading.Event()
    planning, planner = BackgroundPlanner(lambda _: answered.set()), BoardPlanner(ARENA)
    assert planning.plan(planner, request()) is None
    assert answered.wait(PATIENCE)
    assert planning.plan(planner, request()) == "Spring cannot be rendered on the board: a defect"
    planning.close()
    wait_until(lambda: not [t for t in threading.enumerate() if t.name.startswith("hapkit-law")])
