"""The settings that an instructor has locked, and the code that unlocks them.

The lock does not protect against an attack: a user who owns the machine can delete the lock's entry in the
stored settings.
"""

import hashlib
import hmac
import json
import re
import secrets
from collections.abc import Iterable
from dataclasses import dataclass

from hapkit_studio.errors import FileError
from hapkit_studio.files import checked_table, parse_json

Place = tuple[str, ...]
"""A setting: ("environment", key), ("value", environment, parameter), LOOP (with the grip), or DEVICE."""
LOOP, GRIP, DEVICE = ("loop",), ("grip",), ("device",)
ENTRY = "lock"
"""Name of the lock's entry in the stored settings."""
_COST = {"n": 2**14, "r": 8, "p": 1}
_SALT, _DIGEST = 16, 64  # numbers of bytes of salt and digest
# number of elements of a Place, by its first element
_LENGTHS = {"environment": 2, "value": 3, "loop": 1, "grip": 1, "device": 1}


@dataclass(frozen=True)
class Lock:
    """The locked settings and the salted hash of the code; a lock without settings is open."""

    places: frozenset[Place] = frozenset()
    salt: bytes = b""
    digest: bytes = b""

    @classmethod
    def closed(cls, places: Iterable[Place], code: str) -> "Lock":
        """Return a lock for some settings; it has a new salt."""
        salt = secrets.token_bytes(_SALT)
        return cls(frozenset(places), salt, _digest(code, salt))

    def opens(self, code: str) -> bool:
        """Return whether a code is right."""
        return hmac.compare_digest(_digest(code, self.salt), self.digest)

    def covers(self, place: Place) -> bool:
        """Return whether a setting is locked."""
        # the grip can be locked separately, or together with the loop
        hand = place in (GRIP, ("loop", "hand"))
        own = place in self.places or place[:1] in self.places
        return own or (hand and bool({GRIP, LOOP} & set(self.places)))

    def text(self) -> str:
        """Return the lock as a string for the stored settings; "" for an open lock."""
        if not self.places:
            return ""
        places = sorted(self.places)
        return json.dumps({"places": places, "salt": self.salt.hex(), "digest": self.digest.hex()})

    @classmethod
    def read(cls, text: object) -> "Lock":
        """Return the lock from a string made by ``text``; raise FileError if the string is damaged."""
        if text == "":
            return cls()
        stored = checked_table(parse_json(str(text), ENTRY), ENTRY)
        given = stored.get("places")
        places = [_place(place) for place in given] if isinstance(given, list) else []
        if not places or None in places:
            raise FileError(f"{ENTRY}.places holds no settings that can be locked.")
        salt, digest = (
            _bytes(stored.get(name), size) for name, size in (("salt", _SALT), ("digest", _DIGEST))
        )
        return cls(frozenset(place for place in places if place), salt, digest)


def _place(given: object) -> Place | None:
    """Return a stored value as a setting that can be locked; None if it is not such a setting."""
    if not isinstance(given, list) or not given or not all(isinstance(part, str) for part in given):
        return None
    return tuple(given) if len(given) == _LENGTHS.get(given[0]) else None


def _bytes(given: object, size: int) -> bytes:
    if not isinstance(given, str) or not re.fullmatch(rf"[0-9a-f]{{{2 * size}}}", given):
        raise FileError(f"{ENTRY}: salt and digest must be {_SALT} and {_DIGEST} bytes in hexadecimal.")
    return bytes.fromhex(given)


def _digest(code: str, salt: bytes) -> bytes:
    return hashlib.scrypt(code.encode(), salt=salt, **_COST)
