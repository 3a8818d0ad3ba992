"""Random valid code for the machine, with every operation, branches, loops and calls."""

from dataclasses import dataclass

import numpy as np

from hapkit_studio.laws.machine import MOST_COUNTERS, OPERATIONS

BY_NAME = {o.name: o for o in OPERATIONS}
PLAIN = [o for o in OPERATIONS if o.code >= 0x10 and o.operands in ("", "s")]


def code(*parts: str | int | bytes) -> bytes:
    """Return machine code; arguments are names of operations, operands, masks of jumps, and other code."""
    found = b""
    for word in parts:
        found += (
            word
            if isinstance(word, bytes)
            else bytes([BY_NAME[word].code if isinstance(word, str) else word])
        )
    return found


@dataclass(frozen=True)
class RandomCode:
    """A law in the form in which the machine loads it."""

    states: int
    given: tuple[float, ...]
    slots: int
    code: bytes


class _Writer:
    """A writer of random sections of code; it stores each subroutine's offset and number of loop counters."""

    def __init__(self, rng: np.random.Generator, states: int, given: int, slots: int, wild: float):
        self.rng = rng
        self.wild = wild
        self.slots = slots
        self.writable = [*range(2, 2 + states), *range(2 + given, slots)]
        self.subroutines: list[tuple[int, int]] = []  # (offset, number of counters) of each subroutine

    def any(self, things):
        return things[self.rng.integers(len(things))]

    def section(self, marker: str, place: int) -> tuple[bytes, int]:
        body, counters = self.block(int(self.rng.integers(2, 9)), MOST_COUNTERS - 1)
        if marker == "SUBROUTINE":
            self.subroutines.append((place, counters))
        return code(marker) + body + code("RETURN"), counters

    def block(self, count: int, free: int) -> tuple[bytes, int]:
        """Return instructions, and the number of loop counters that they use.

        Counters have numbers below ``free``.
        """
        found, used = b"", 0
        for _ in range(count):
            more, counters = self.instruction(count // 2, free)
            found, used = found + more, max(used, counters)
        return found, used

    def instruction(self, inside: int, free: int) -> tuple[bytes, int]:
        rng, slot = self.rng, int(self.rng.integers(self.slots))
        kind = rng.random()
        if kind < 0.40:
            one = self.any(PLAIN)
            return code(one.name, *([slot] if one.operands else [])), 0
        if kind < 0.52:
            return code("LOAD", slot), 0
        if kind < 0.64:
            return code("STORE", self.any(self.writable)), 0
        if kind < 0.68:
            size = int(rng.integers(1, self.slots + 1))
            return code("LOAD_AT", slot, int(rng.integers(self.slots - size + 1)), size), 0
        if kind < 0.71:
            return code("STORE_AT", slot, self.writable[-1], 1), 0
        if kind < 0.80 and self.subroutines:
            place, counters = self.any(self.subroutines)
            if counters <= free or rng.random() < self.wild:
                return code("CALL", place % 256, place // 256), counters
        if kind < 0.89 and inside and (free > 0 or rng.random() < self.wild):
            return self.loop(inside, max(free, 1))
        return self.branch(inside, free)

    def loop(self, inside: int, free: int) -> tuple[bytes, int]:
        counter = int(self.rng.integers(free))
        body, used = self.block(inside, counter)
        tail = b""
        if self.rng.random() < 0.5:  # write a jump out of the loop
            tail, more = self.block(inside, free)
            used = max(used, more)
            rest, more = self.block(inside // 2, counter)
            used = max(used, more)
            if len(rest) + 6 < 256 and len(tail) < 256:
                body += code(0x50 + int(self.rng.integers(16)), len(rest) + 6) + rest
                tail = code("JUMP", len(tail)) + tail
            else:
                tail = b""
        back = len(body) + 4
        times = int(self.rng.integers(1, 5))
        found = code("LOOP", counter, times, 0, body, "NEXT", counter, back % 256, back // 256, tail)
        return found, max(used, counter + 1)

    def branch(self, inside: int, free: int) -> tuple[bytes, int]:
        mask = int(self.rng.integers(16))
        head = [0x50 + mask] if self.rng.random() < 0.5 else [0x40 + mask, int(self.rng.integers(self.slots))]
        then, used = self.block(inside, free)
        other, more = self.block(inside, free)
        if self.rng.random() < 0.2:
            then += code("RETURN")
        elif self.rng.random() < 0.5:
            then += (
                code("JUMP", len(other))
                if len(other) < 256
                else code("FAR_JUMP", len(other) % 256, len(other) // 256)
            )
        if len(then) > 255:
            return b"", 0
        return code(*head, len(then), then, other), max(used, more)


def random_code(rng: np.random.Generator, wild: float = 0.0) -> RandomCode:
    """Return a law of a few dozen instructions that the verifier accepts unless it has too many cycles.

    ``wild`` is the probability that a loop uses a counter already in use, which the verifier rejects.
    """
    states, constants, temporaries = (int(n) for n in rng.integers(0, 4, 3))
    given, slots = states + constants, 2 + states + constants + temporaries + 1
    writer, found = _Writer(rng, states, given, slots, wild), b""
    for _ in range(int(rng.integers(3))):
        found += writer.section("SUBROUTINE", len(found))[0]
    found += writer.section("MAIN", len(found))[0]
    numbers = np.float32(rng.normal(size=given) * 10.0 ** rng.uniform(-2, 2, given))
    return RandomCode(states, tuple(numbers.tolist()), slots, found)
