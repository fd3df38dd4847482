"""Little work space for tests of polygons, in the interpreter."""

from hknob_cli.engine.sets.polygon import CELL, CORNERS, POLYGON
from hknob_cli.engine.sets.room import PolygonRoom


def zeros(count: int) -> list[float]:
    return [0.0] * count


def small_room(polygons: int = 32, slots: int = 16) -> PolygonRoom:
    return PolygonRoom(
        stack=zeros(POLYGON * polygons),
        own=zeros(POLYGON),
        corners=zeros(2 * CORNERS),
        parts=zeros(8 * CORNERS),
        halves=zeros(4 * CORNERS),
        moved=zeros(4 * CORNERS),
        ring=[],
        used=zeros(slots),
        keys=zeros(2 * slots),
        cells=zeros(CELL * slots),
        singles=zeros(POLYGON * slots),
        taken=zeros(slots),
        counts=zeros(1),
    )


def waiting(room: PolygonRoom, at: int) -> list[float]:
    return room.stack[POLYGON * at : POLYGON * (at + 1)]
