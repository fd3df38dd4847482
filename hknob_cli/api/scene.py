"""A scene, from Python: its parts by name, checked when it is made, and specs made of it."""

import json
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Literal

from hknob_cli.api.stages import load, plain

if TYPE_CHECKING:
    from hknob_cli.specs.parts import Scene as Numbers

Part = Mapping[str, Any]
HERE = "<scene>"  # in faults


class Scene(Mapping[str, Any]):
    """What exists: a knob, a hand, a wall and the rest. It is checked at once, and never changes.

    A scene is a mapping, so that it can stand in a spec, under ``scene``. Printed, it is its parts in words.

    >>> knob = hk.Scene(knob={"inertia": "19 g*cm^2"}, wall={"stiffness": 0.27}, hand={"table": 1, "grip_n": 0.71})
    >>> pushed = knob.but({"bias.torque": "1 mN*m"})
    >>> hk.sweep(pushed.spec("mine", grid={"sample_rate_hz": 1000, "counts_per_rev": [512, 1024]}))
    """

    def __init__(
        self,
        preset: str | None = None,
        /,
        *,
        knob: Part | None = None,
        hand: Part | None = None,
        wall: Part | None = None,
        bias: Part | None = None,
        encoder: Part | Literal["none"] | None = None,
        actuator: Part | None = None,
        sampling: Literal["zero_order_hold", "continuous"] | None = None,
        controller: Part | None = None,
        profile: Part | None = None,
        detents: Part | None = None,
        end_stops: Part | None = None,
        dead_zone: Part | None = None,
        motor: Part | None = None,
        eddy_brake: Part | None = None,
        gear: Part | None = None,
        squeeze: Part | None = None,
        clock: Part | None = None,
        cogging: Part | None = None,
    ) -> None:
        """Parts as a spec has them (``docs/reference/scene.md``); None: not listed.

        ``preset`` is the name of a known knob, or the path of its file, which the parts are merged over. Raises
        `SpecError` with every fault.
        """
        given = {key: value for key, value in locals().items() if key not in ("self", "preset") and value is not None}
        self._take({**({"from": preset} if preset is not None else {}), **given})

    def _take(self, parts: Mapping[str, Any]) -> None:
        self._parts: dict[str, Any] = plain(parts)
        plan: Any = load(self.spec("scene"), kind="sweep", name=HERE)
        self._numbers: Numbers = plan.scene

    def but(self, changes: Mapping[str, Any]) -> "Scene":
        """The same with some values changed, by dotted path: ``{"wall.stiffness": 0.5}``; None takes a part away.

        Raises `SpecError` with every fault.
        """
        parts = plain(self._parts)
        for path, value in changes.items():
            target, (*above, last) = parts, path.split(".")
            for step in above:
                inner = target.get(step)
                target[step] = inner = dict(inner) if isinstance(inner, dict) else {}
                target = inner
            if value is None and "from" not in parts:
                target.pop(last, None)
            else:
                target[last] = value
        made = Scene.__new__(Scene)
        made._take(parts)
        return made

    def spec(
        self,
        name: str,
        *,
        kind: Literal["sweep", "dfa", "predict"] = "sweep",
        grid: Mapping[str, Any] | None = None,
        **keys: Any,
    ) -> dict[str, Any]:
        """A spec with this scene, for the function of its ``kind``; it is checked there.

        Args:
            name: of the results.
            kind: which question is asked.
            grid: values by axis; None: those of the preset, else 1000 Hz and 1024 counts.
            keys: further keys of the spec, such as ``starts`` and ``perceive``.
        """
        given = dict(grid or {})
        if grid is None and "from" not in self._parts:
            clock = {} if self._parts.get("sampling") == "continuous" else {"sample_rate_hz": 1000}
            given = {**clock, **({} if self._parts.get("encoder") == "none" else {"counts_per_rev": 1024})}
        return {"kind": kind, "name": name, "scene": self._parts, **({"grid": given} if given else {}), **keys}

    @property
    def numbers(self) -> "Numbers":
        """Its parts as plain values in SI units: ``scene.numbers.hand.stiffness``; None for a part that it lacks."""
        return self._numbers

    def __getitem__(self, key: str) -> Any:
        """A part as it was given."""
        return self._parts[key]

    def __iter__(self) -> Iterator[str]:
        """Names of the parts that were given."""
        return iter(self._parts)

    def __len__(self) -> int:
        """How many parts were given."""
        return len(self._parts)

    def __str__(self) -> str:
        """Its parts in words, in SI units."""
        from hknob_cli.report.scene_words import scene_sentences

        return "\n".join(scene_sentences(self._numbers, {}))

    def __repr__(self) -> str:
        """Its parts as they were given."""
        return f"Scene({json.dumps(self._parts)})"
