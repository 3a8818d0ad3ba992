"""How a message is declared: a frozen dataclass whose fields carry their type on the wire."""

import struct
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar, NamedTuple, Self

FROM_BOARD = 0x80


class Wire(NamedTuple):
    """One field on the wire: name, struct code, unit and explanation."""

    name: str
    code: str
    unit: str
    help: str

    @property
    def size(self) -> int:
        return struct.calcsize("<" + self.code)

    @property
    def numbers(self) -> int:
        """How many numbers the field holds; text is one value."""
        return 1 if self.code.endswith("s") else int(self.code[:-1] or 1)


def wire(code: str, help: str, unit: str = "") -> Any:
    """Declare a field by its struct code: ``"H"``, ``"16s"`` for text, ``"8B"`` for a tuple of numbers."""
    return field(metadata={"code": code, "unit": unit, "help": help})


@dataclass(frozen=True)
class Message:
    """Base of all messages; a subclass names its id, whose top bit says that it comes from the board."""

    ID: ClassVar[int]

    def __init_subclass__(cls, id: int) -> None:
        cls.ID = id

    @classmethod
    def from_board(cls) -> bool:
        """Tell whether the board sends this message."""
        return bool(cls.ID & FROM_BOARD)

    @classmethod
    def layout(cls) -> tuple[Wire, ...]:
        """Return the fields in the order in which they travel, without gaps."""
        return tuple(
            Wire(f.name, f.metadata["code"], f.metadata["unit"], f.metadata["help"]) for f in fields(cls)
        )

    @classmethod
    def size(cls) -> int:
        """Return the number of payload bytes, without the id."""
        return sum(f.size for f in cls.layout())

    @classmethod
    def offset(cls, name: str) -> int:
        """Return where a field starts in id plus payload."""
        names = [f.name for f in cls.layout()]
        return 1 + sum(f.size for f in cls.layout()[: names.index(name)])

    @classmethod
    def _format(cls) -> str:
        return "<B" + "".join(f.code for f in cls.layout())

    def pack(self) -> bytes:
        """Return id and payload, little endian; raise struct.error if a value does not fit."""
        values: list[Any] = []
        for f in self.layout():
            value = getattr(self, f.name)
            if f.code.endswith("s"):
                values.append(value.encode("ascii"))
            else:
                values += value if f.numbers > 1 else [value]
        return struct.pack(self._format(), self.ID, *values)

    @classmethod
    def unpack(cls, body: bytes) -> Self:
        """Return the message in id plus payload; raise ValueError if the size or the id is another's."""
        if len(body) != 1 + cls.size() or body[0] != cls.ID:
            raise ValueError(
                f"{cls.__name__} is {1 + cls.size()} bytes starting with {cls.ID}, not {body!r}."
            )
        _, *raw = struct.unpack(cls._format(), body)
        values: list[Any] = []
        for f in cls.layout():
            several, raw = raw[: f.numbers], raw[f.numbers :]
            if f.code.endswith("s"):
                values.append(several[0].rstrip(b"\0").decode("ascii", "replace"))
            else:
                values.append(tuple(several) if f.numbers > 1 else several[0])
        return cls(*values)
