"""What an instructor has locked, and the code that unlocks it. It keeps order, not secrets: its settings
entry can be deleted by whoever owns the machine."""

import hashlib
import hmac
import json
import secrets
from collections.abc import Iterable
from dataclasses import dataclass

Place = tuple[str, ...]
"""A setting: ("environment", key), ("value", environment, parameter), LOOP with the grip, or DEVICE."""
LOOP, GRIP, DEVICE = ("loop",), ("grip",), ("device",)
ENTRY = "lock"
"""Under which it stands in the settings."""
_COST = {"n": 2**14, "r": 8, "p": 1}


@dataclass(frozen=True)
class Lock:
    """The settings that are fixed, and the salted hash of the code; without settings it is open."""

    places: frozenset[Place] = frozenset()
    salt: bytes = b""
    digest: bytes = b""

    @classmethod
    def closed(cls, places: Iterable[Place], code: str) -> "Lock":
        """Return a lock of some settings with a new salt."""
        salt = secrets.token_bytes(16)
        return cls(frozenset(places), salt, _digest(code, salt))

    def opens(self, code: str) -> bool:
        """Say whether a code is the right one."""
        return hmac.compare_digest(_digest(code, self.salt), self.digest)

    def holds(self, place: Place) -> bool:
        """Say whether a setting is fixed."""
        return place in self.places or place[:1] in self.places or (place == GRIP and LOOP in self.places)

    def text(self) -> str:
        """Return it as the settings keep it, "" for an open one."""
        if not self.places:
            return ""
        places = sorted(self.places)
        return json.dumps({"places": places, "salt": self.salt.hex(), "digest": self.digest.hex()})

    @classmethod
    def read(cls, text: str) -> "Lock":
        """Return what ``text`` wrote; what cannot be read is open, as no code would open it."""
        try:
            kept = json.loads(text)
            places = frozenset(tuple(map(str, place)) for place in kept["places"])
            return cls(places, bytes.fromhex(kept["salt"]), bytes.fromhex(kept["digest"]))
        except (ValueError, KeyError, TypeError):
            return cls()


def _digest(code: str, salt: bytes) -> bytes:
    return hashlib.scrypt(code.encode(), salt=salt, **_COST)
