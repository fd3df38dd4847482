"""A grip that follows the push: fingers squeeze as hard as the torque asks that they hold.

Two fingers that press with a force F on a knob of radius r hold a torque of 2 mu F r before they slip. So a knob that
is pushed deeper into a wall, which pushes back harder, needs a firmer grip, and a firmer grip damps and holds more
(Tables 1-5). Source: Hasser, Chapter 11 (nonlinear virtual barriers). A coefficient of friction is not printed.
"""

from math import inf

from hknob_cli.specs.drive import reduced
from hknob_cli.specs.parts import Hand, Scene

# Beginnings of the paths of all numbers, beside those of the hand, that a grip depends on.
DECIDING = ("squeeze.", "bias.", "wall.", "controller.", "actuator.", "motor.", "gear.")


def squeezed(scene: Scene) -> Scene:
    """The `Scene` with the hand of the grip that its push asks for, in place of ``squeeze``.

    At rest inside the wall, at a depth d, the wall's torque T(d) and the hand's spring k d hold the push g. The fingers
    hold T(d), so the grip is F = max(F0, margin T(d) / (2 mu r)), and k, with inertia and damping, is that of F, linear
    between the rows of the table. T is at most the torque limit of actuator or motor. Behind a gear of stiffness c the
    motor is at the depth d, and the mesh carries T(d): the knob is at d + T(d) / c, which its hand's spring feels. The
    push holds the teeth on the flank from which angles are counted, so that backlash changes nothing.

    There is one answer, because in Tables 1-5 a firmer grip is never softer: then T(d) + k (d + T(d) / c) rises with d,
    for T does. It is found by bisection to the last digit. The grip is that of rest, and does not follow the buzz.

    Left out are the rounding to counts, and friction and cogging, with which a push has many rests (`left_out`).
    """
    if scene.squeeze is None or scene.hand is None:
        return scene
    return scene._replace(hand=hand_at(scene.hand, grip_of(scene)), squeeze=None)


def grip_of(scene: Scene) -> float:
    """The grip force (N) that the push of a `Scene` with ``squeeze`` asks for, at least that of its hand."""
    assert scene.squeeze is not None
    assert scene.hand is not None
    own = scene.hand
    least = next(grip for grip, hand in own.by_grip if hand[:3] == own[:3])
    per_newton_meter = scene.squeeze.newtons_per_newton_meter
    push = scene.bias.torque if scene.bias and scene.bias.torque else 0.0
    mesh = scene.gear.stiffness if scene.gear and scene.gear.stiffness is not None else inf
    low, high = 0.0, push / own.stiffness  # there the hand holds it alone
    while low < (middle := 0.5 * (low + high)) < high:
        torque = _wall_torque(scene, middle)
        spring = hand_at(own, max(least, per_newton_meter * torque)).stiffness
        low, high = (middle, high) if torque + spring * (middle + torque / mesh) < push else (low, middle)
    return float(max(least, per_newton_meter * min(_wall_torque(scene, high), _most_torque(scene))))


def _most_torque(scene: Scene) -> float:
    """The most torque (N·m) that actuator or motor gives, on the knob.

    A wall that asks for more gives just this: without the limit the motor would rest where T is larger, and the limit
    only lets it go deeper, so that T stays above.
    """
    actuator = reduced(scene).actuator
    return inf if actuator is None or actuator.torque_limit is None else actuator.torque_limit


def left_out(scene: Scene) -> float:
    """The most (N) by which friction and cogging move the grip that a rest asks for away from `grip_of`.

    It is margin C / (2 mu r), with C (N·m) what both give at most, on the knob. Where they add a torque c, the fingers
    hold H = T(d) + c, at a depth d that follows from H by the hand's spring.

    Where H >= 0, a larger H means a smaller d, so that H - T(d) rises by at least as much as H. It is 0 at the rest
    without c, and c at this one: the two H differ by at most C. Where H < 0, |H| is at most C, for T >= 0. A rest
    without c that holds more than |H| has a firmer hand and is less deep. So it holds at most T(d) = H - c < C.
    """
    assert scene.squeeze is not None
    alone = reduced(scene)
    torque = alone.knob.coulomb_torque + (alone.cogging.torque if alone.cogging else 0.0)
    return scene.squeeze.newtons_per_newton_meter * torque


def hand_at(hand: Hand, grip_n: float) -> Hand:
    """The hand of a table at any grip force between its rows: linear between them, and as at the ends beyond."""
    rows = hand.by_grip
    (below, one), (above, other) = rows[0], rows[0]
    for row in rows:
        below, one, above, other = above, other, *row
        if grip_n <= above:
            break
    share = (grip_n - below) / (above - below) if above > below else 0.0
    inertia, damping, stiffness = (
        a + share * (b - a) if share < 1.0 else b for a, b in zip(one[:3], other[:3], strict=True)
    )
    return hand._replace(inertia=inertia, damping=damping, stiffness=stiffness)


def _wall_torque(scene: Scene, depth: float) -> float:
    """Torque (N·m) of the wall at rest at a depth (rad): of its spring, or of the wall that stiffens with depth."""
    torque, controller = scene.wall.stiffness * depth, scene.controller
    if controller is None or controller.kind != "stiffening":
        return torque
    return torque * (controller.surface + (1.0 - controller.surface) * min(depth / controller.depth, 1.0))
