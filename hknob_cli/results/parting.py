"""How the rows of a large result are cut into parts: by the number of their item, so many items to a part."""

from typing import NamedTuple

from hknob_cli.results.parted import PART_CELLS, part_metadata


class Parting(NamedTuple):
    """``total`` items in parts of ``most``, of a result with this provenance; no more than ``most`` are in no parts."""

    total: int
    provenance: bytes
    most: int = PART_CELLS

    @property
    def parted(self) -> bool:
        """Whether there are parts."""
        return self.total > self.most

    @property
    def items(self) -> int:
        """Items in a part, or in all."""
        return self.most if self.parted else max(1, self.total)

    @property
    def parts(self) -> int:
        """Number of parts, 1 if there are none."""
        return -(-self.total // self.items)

    def range(self, number: int) -> tuple[int, int]:
        """Items of a part: the first, and the one behind the last."""
        return number * self.items, min(self.total, (number + 1) * self.items)

    def whole(self, start: int, stop: int) -> int | None:
        """The part that items ``start`` to ``stop`` are, all of it; None if they are none."""
        number = start // self.items
        return number if self.parted and (start, stop) == self.range(number) else None

    def metadata(self, number: int) -> dict[bytes, bytes]:
        """What a part says of itself."""
        return part_metadata(number, self.parts, self.provenance)
