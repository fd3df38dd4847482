"""Many cells of a grid at once: a scene whose numbers are arrays, with one entry a cell, reduced like one.

The arithmetic is `sampled_knob.reduce_scene`, element by element, so that the numbers are those of each cell alone.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hknob_cli.scene.sampled_knob import SampledKnob, overflows, reduce_scene
from hknob_cli.specs.plan import COUNTS, GRIP, PERSON, RATE, Hand, Scene, gripped, placed, scene_at
from hknob_cli.specs.squeeze import squeezed

Columns = Mapping[str, NDArray[Any]]


def sample_cells(scene: Scene, columns: Columns) -> SampledKnob:
    """Reduce a scene to the cells whose axis values are ``columns``, (n,) each.

    Numbers that vary are arrays (n,), also those of samples under way; the response over the holds is left at 0. Raises
    `ComputationError` for the first cell whose numbers overflow.
    """
    rates, counts = columns[RATE], columns[COUNTS]
    with np.errstate(all="ignore"):
        knob, size = reduce_scene(scene_along(scene, columns), sample_rate_hz=_any(rates), counts_per_rev=_any(counts))
    wild = np.flatnonzero(~np.isfinite(np.broadcast_to(size, rates.shape)))
    if wild.size:
        raise overflows(float(rates[wild[0]]), int(counts[wild[0]]))
    return knob


def scene_along(scene: Scene, columns: Columns) -> Scene:
    """The scene with columns of values in place, as `scene_at` puts those of one cell."""
    if scene.squeeze:
        return _squeezed_along(scene, columns)
    if scene.hand and GRIP in columns:
        grips, which = np.unique(columns[GRIP], return_inverse=True)
        hands = [gripped(scene.hand, float(grip)) for grip in grips]
        inertia, damping, stiffness = np.array([hand[:3] for hand in hands]).T[:, which]
        scene = scene._replace(hand=Hand(inertia=_any(inertia), damping=_any(damping), stiffness=_any(stiffness)))
    if scene.hand and PERSON in columns:
        inertia, damping, stiffness = hands_of(scene.hand, columns[PERSON])
        scene = scene._replace(hand=Hand(inertia=_any(inertia), damping=_any(damping), stiffness=_any(stiffness)))
    return scene_at(scene, {name: _any(values) for name, values in columns.items() if name not in (GRIP, PERSON)})


def _squeezed_along(scene: Scene, columns: Columns) -> Scene:
    """The same where the grip follows the push, and with it the hand of every cell."""
    names = [name for name in columns if name not in (RATE, COUNTS)]
    if not names:
        return scene_along(squeezed(scene), columns)
    different, which = np.unique(np.array([columns[name] for name in names]).T, axis=0, return_inverse=True)
    cells = [dict(zip(names, row, strict=True)) for row in different.tolist()]
    hands = [(squeezed(placed(scene, cell)).hand or Hand())[:3] for cell in cells]
    inertia, damping, stiffness = np.array(hands).T[:, which.ravel()]
    made = scene._replace(
        hand=Hand(inertia=_any(inertia), damping=_any(damping), stiffness=_any(stiffness)), squeeze=None
    )
    kept = {name: values for name, values in columns.items() if name != GRIP and not name.startswith("squeeze.")}
    return scene_along(made, kept)


def hands_of(hand: Hand, persons: NDArray[Any]) -> NDArray[np.float64]:
    """Inertia, damping and stiffness of people's hands, of those of a population, (3, n) for their numbers (n,)."""
    numbers, which = np.unique(persons, return_inverse=True)
    found: NDArray[np.float64] = np.array([hand.by_person[int(one) - 1][:3] for one in numbers], dtype=np.float64)
    return found.T[:, which]


def _any(values: NDArray[Any]) -> Any:
    """An array in the place of a number."""
    return values
