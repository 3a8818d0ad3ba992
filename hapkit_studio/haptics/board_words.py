"""What the computer says to a board that renders, or is to render: settings, loop, scene, that it is there.

Each function writes its frames to ``frame`` and returns their length.
"""

from hapkit_studio.dynamics.jit import compiled, internal
from hapkit_studio.haptics import block, line, rig, way
from hapkit_studio.protocol import codec, scene_frames
from hapkit_studio.protocol.scene_frames import NO_LAW, VALUES

_APART = 5e-3
_LOOP_FIRST = 3e-3
ALIVE_APART = 4e-3
"""s between two words that the computer is there. A board goes silent 25 ms after the last: five may be lost.

Each costs it 300 cycles.
"""
_HALF_FRAME = 0.5e-3


@compiled
def speak(r, conn, k, now, frame):
    """Answer frame k; a second long message never goes out within 5 ms, the newest wins."""
    n, words = conn.numbers, conn.words
    n[line.LAST_ANSWER] = now
    at = words[way.WAY]
    if at == way.LEAVING:
        length = zero(conn, k, frame)
        return length + begin(r, conn, k, now, frame[length:])
    if at == way.SETTING:
        return settle(r, conn, k, now, frame)
    law = way.wanted(r, conn)
    if at == way.THERE and law == NO_LAW:
        words[way.WAY], at = way.RETURNING, way.RETURNING
        n[way.ASKED_AT] = -way.PATIENCE
    if at == way.RETURNING:
        return give_over(r, conn, k, now, frame)
    if at == way.ASKING:
        return ask(r, conn, k, now, frame)
    return go_on(r, conn, k, now, frame, law)


@internal
def zero(conn, k, frame):
    """Encode a force of zero in answer to sample k."""
    return codec.encode_force(frame, int(conn.samples[k, codec.SEQ]), 0.0)


@internal
def begin(r, conn, k, now, frame):
    """Begin to hand over, the force at zero: the zero first, where the board has another one."""
    n, words = conn.numbers, conn.words
    if words[way.CONFIGURABLE] and (n[line.ZERO] != 0.0 or n[line.SIGN] < 0.0):
        fold(conn)
        words[way.WAY] = way.SETTING
        n[way.ASKED_AT] = -way.PATIENCE
        words[way.SETTINGS_SEEN] = conn.reader[codec.SETTINGS_FRAMES]
        return settle(r, conn, k, now, frame)
    words[way.WAY] = way.ASKING
    n[way.ASKED_AT] = -way.PATIENCE
    return ask(r, conn, k, now, frame)


@internal
def fold(conn):
    """Put the zero and direction that a person has set into the settings that the board is to take over.

    The board's zero counts before its sense; its force follows its direction.
    """
    body, n = conn.settings, conn.numbers
    sense = scene_frames.signed(body, scene_frames.AT_SENSE, 1)
    zero = scene_frames.signed(body, scene_frames.AT_ZERO, 4) + sense * int(n[line.ZERO])
    scene_frames.put_signed(body, scene_frames.AT_ZERO, 4, zero)
    if n[line.SIGN] < 0.0:
        direction = scene_frames.signed(body, scene_frames.AT_DIRECTION, 1)
        scene_frames.put_signed(body, scene_frames.AT_SENSE, 1, -sense)
        scene_frames.put_signed(body, scene_frames.AT_DIRECTION, 1, -direction)


@internal
def settle(r, conn, k, now, frame):
    """Wait until the board has the settings; from the next frame on its counts are ours."""
    n, words = conn.numbers, conn.words
    if conn.reader[codec.SETTINGS_FRAMES] != words[way.SETTINGS_SEEN]:
        n[line.ZERO], n[line.SIGN] = 0.0, 1.0
        words[way.WAY] = way.ASKING
        n[way.ASKED_AT] = -way.PATIENCE
        return ask(r, conn, k, now, frame)
    if now - n[way.ASKED_AT] < way.PATIENCE:
        return zero(conn, k, frame)
    n[way.ASKED_AT] = now
    return scene_frames.encode_body(frame, conn.settings)


@internal
def ask(r, conn, k, now, frame):
    """Say how fast to render, some frames later what; again where no telemetry comes.

    One long message at a time: the board has room for 128 bytes that wait while it works on one.
    """
    n, words = conn.numbers, conn.words
    time = conn.samples[k, codec.BOARD_TIME]
    if now - n[way.ASKED_AT] >= way.PATIENCE:
        n[way.ASKED_AT], n[way.ALIVE_AT] = now, time
        words[way.SCENE_DUE] = 1
        return loop(r, conn, now, frame)
    if words[way.SCENE_DUE] and not 0.0 <= time - n[way.ALIVE_AT] < _LOOP_FIRST:
        words[way.LAW_SENT] = NO_LAW
        return scene(r, conn, way.wanted(r, conn), now, frame)
    return codec.encode_simple(frame, scene_frames.ALIVE)


@internal
def give_over(r, conn, k, now, frame):
    """Tell the board that the computer renders; again where telemetry goes on."""
    n = conn.numbers
    if now - n[way.ASKED_AT] < way.PATIENCE:
        return now_and_then(conn, k, frame, scene_frames.ALIVE)
    n[way.ASKED_AT] = now
    return scene(r, conn, NO_LAW, now, frame)


@internal
def go_on(r, conn, k, now, frame, law):
    """Say what is new, or what has no effect yet, or only that the computer is there."""
    n, words = conn.numbers, conn.words
    if r.word[rig.STALE]:
        return now_and_then(conn, k, frame, scene_frames.HELLO_REQUEST)
    since = now - n[way.SAID_AT]
    unheard = since >= way.PATIENCE and int(conn.samples[k, codec.GENERATION]) != words[way.GENERATION] & 0xFF
    other, new = other_loop(r, conn), unheard or words[way.SCENE_DUE] or news(r, conn, law)
    if since < _APART or not (other or new):
        return now_and_then(conn, k, frame, scene_frames.ALIVE)
    slower = r.words[block.BOARD_RATE] <= words[way.SENT_RATE]
    if other and (slower or not new):  # a slow law never runs at a fast one's rate
        return loop(r, conn, now, frame)
    return scene(r, conn, law, now, frame)


@internal
def other_loop(r, conn):
    """Return whether the board is to render at another rate or with another estimator."""
    n, words = conn.numbers, conn.words
    return (
        words[way.SENT_RATE] != r.words[block.BOARD_RATE]
        or words[way.SENT_ESTIMATOR] != r.words[block.BOARD_ESTIMATOR]
        or n[way.SENT_FIRST] != r.values[block.BOARD_FIRST]
        or n[way.SENT_SECOND] != r.values[block.BOARD_SECOND]
    )


@internal
def news(r, conn, law):
    """Return whether law or parameters are others than the board has."""
    if conn.words[way.LAW_SENT] != law:
        return True
    for i in range(VALUES):
        if conn.sent[i] != r.values[block.PARAMS + i]:
            return True
    return False


@internal
def scene(r, conn, law, now, frame):
    """Say what is to be rendered."""
    n, words = conn.numbers, conn.words
    words[way.GENERATION] += 1
    words[way.SCENE_DUE] = 0
    if words[way.LAW_SENT] != law:
        words[way.FIRST_OF_LAW] = words[way.GENERATION]
    words[way.LAW_SENT] = law
    n[way.SAID_AT] = now
    for i in range(VALUES):
        conn.sent[i] = r.values[block.PARAMS + i]
    return scene_frames.encode_scene(frame, law, words[way.GENERATION], conn.sent)


@internal
def loop(r, conn, now, frame):
    """Say how fast and with which estimator."""
    n, words = conn.numbers, conn.words
    n[way.SAID_AT] = now
    rate, kind = r.words[block.BOARD_RATE], r.words[block.BOARD_ESTIMATOR]
    first, second = r.values[block.BOARD_FIRST], r.values[block.BOARD_SECOND]
    words[way.SENT_RATE], words[way.SENT_ESTIMATOR] = rate, kind
    n[way.SENT_FIRST], n[way.SENT_SECOND] = first, second
    return scene_frames.encode_loop(frame, rate, kind, first, second)


@internal
def now_and_then(conn, k, frame, word):
    """Say a word without fields every few milliseconds by the board's clock."""
    time = conn.samples[k, codec.BOARD_TIME]
    if 0.0 <= time - conn.numbers[way.ALIVE_AT] < ALIVE_APART - _HALF_FRAME:
        return 0
    conn.numbers[way.ALIVE_AT] = time
    return codec.encode_simple(frame, word)


@compiled
def last_act(conn, frame):
    """Take the board's law away, then command zero: the last act of a loop while the board renders.

    Told twice the board does so at once; told once it lets its force go out over 30 ms.
    """
    generation = conn.words[way.GENERATION] + 1
    length = scene_frames.encode_scene(frame, NO_LAW, generation, conn.sent)
    length += scene_frames.encode_scene(frame[length:], NO_LAW, generation, conn.sent)
    return length + codec.encode_force(frame[length:], 0, 0.0)


@compiled
def hello(frame):
    """Ask whether anybody is there: what does not keep the motor on."""
    return codec.encode_simple(frame, scene_frames.HELLO_REQUEST)
