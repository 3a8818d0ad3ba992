"""Strategies of messages, bodies and damage for property tests."""

from hypothesis import strategies as st

from hapkit_studio.protocol.messages import MESSAGES, Sample

_INTEGERS = {
    "B": (0, 255),
    "b": (-128, 127),
    "h": (-32768, 32767),
    "H": (0, 65535),
    "i": (-(2**31), 2**31 - 1),
    "I": (0, 2**32 - 1),
}


def values(wire):
    """Return a strategy for one field."""
    if wire.numbers > 1:
        one = values(wire._replace(code=wire.code[-1]))
        return st.tuples(*[one] * wire.numbers)
    if wire.code in _INTEGERS:
        low, high = _INTEGERS[wire.code]
        return st.integers(low, high) | st.sampled_from([low, 0, 1, high])
    if wire.code == "f":
        return st.floats(width=32, allow_nan=False)
    return st.text(st.characters(min_codepoint=33, max_codepoint=126), max_size=wire.size)


def messages_of(kind):
    """Return a strategy for messages of one kind."""
    return st.builds(kind, **{wire.name: values(wire) for wire in kind.layout()})


any_message = st.one_of([messages_of(kind) for kind in MESSAGES])
samples = messages_of(Sample)
bodies = st.binary(min_size=1, max_size=40) | st.lists(st.sampled_from([0, 1, 255]), min_size=1).map(bytes)
