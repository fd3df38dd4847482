"""The hand on the knob as a mechanism: of second order, or with finger and fingerpad of their own."""

from typing import NamedTuple

FINGER_INERTIA = 3e-7  # kg m^2, "a generous estimate", section 4.4.1
FINGER_TO_PAD = 10.0  # K1 / K2 = B1 / B2, ibid.


class SecondOrder(NamedTuple):
    """J θ'' + B θ' + K θ = T: inertia (kg·m²) of hand and apparatus together, damping (N·m·s/rad), stiffness (N·m/rad).

    The inertia is one number because the firm grips of Tables 1-5 have less of it than the apparatus alone.
    """

    inertia: float
    damping: float
    stiffness: float


class FourthOrder(NamedTuple):
    """The knob (inertia, kg·m²), by a fingerpad (damping, stiffness) on a finger that is held to ground.

    Source: equation 1; the knob is the network's J2, the finger its J1, B1, K1, the fingerpad its B2, K2.
    """

    inertia: float
    finger_inertia: float
    finger_damping: float
    finger_stiffness: float
    pad_damping: float
    pad_stiffness: float


Hand = SecondOrder | FourthOrder


def split(hand: SecondOrder, *, knob_kg_m2: float, finger_kg_m2: float = FINGER_INERTIA) -> FourthOrder:
    """Finger and fingerpad in series that have the hand's damping and stiffness; its inertia does not enter.

    Source: section 4.4.1, K_T = K1 K2 / (K1 + K2) and B_T alike, with K1 = 10 K2 and B1 = 10 B2.
    """
    pad = (1.0 + FINGER_TO_PAD) / FINGER_TO_PAD
    return FourthOrder(
        inertia=knob_kg_m2,
        finger_inertia=finger_kg_m2,
        finger_damping=FINGER_TO_PAD * pad * hand.damping,
        finger_stiffness=FINGER_TO_PAD * pad * hand.stiffness,
        pad_damping=pad * hand.damping,
        pad_stiffness=pad * hand.stiffness,
    )


def static_stiffness(hand: Hand) -> float:
    """Stiffness (N·m/rad) that holds the knob against a constant torque."""
    if isinstance(hand, SecondOrder):
        return hand.stiffness
    total = hand.finger_stiffness + hand.pad_stiffness
    return hand.finger_stiffness * hand.pad_stiffness / total if total > 0.0 else 0.0
