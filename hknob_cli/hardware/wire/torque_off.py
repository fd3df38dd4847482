"""Whether a target is in the state that a command leaves it in, and whether its torque is off once it should be."""

from hknob_cli.hardware.port import Block
from hknob_cli.hardware.wire.answers import Ack, Samples
from hknob_cli.hardware.wire.codes import Kind, State, Status

# After these a target that did as it was told is in this state. One that trips meanwhile, armed or running, says so.
_AFTER = {
    Kind.CONFIGURE: (State.IDLE,),
    Kind.SIMULATE: (State.IDLE,),
    Kind.ZERO: (State.IDLE,),
    Kind.ARM: (State.ARMED, State.TRIPPED),
    Kind.START: (State.RUNNING, State.TRIPPED),
    Kind.STOP: (State.IDLE,),
    Kind.RELEASE: (State.IDLE,),
}


def wrong_state(ack: Ack) -> str:
    """What is wrong with the state in an answer; empty if nothing is."""
    told = Kind(ack.of)
    if ack.status is not Status.DONE or ack.state in _AFTER.get(told, tuple(State)):
        return ""
    wanted = _AFTER[told][0].name.lower()
    return f"the target acknowledged {told.name}, but says that it is {ack.state.name.lower()}, and not {wanted}"


def shows_torque(block: Block) -> bool:
    """Whether any sample of a block has the wall on, or a torque."""
    return bool(block.running.any() or (block.torque_nm != 0.0).any())


class AfterRelease:
    """What a target shows after it was told to release: ``seen`` is empty where nothing speaks against it."""

    def __init__(self, *, boot: int | None) -> None:
        self.seen = ""
        self.acknowledged = False
        self._boot = boot

    def answer(self, ack: Ack) -> None:
        """The answer to RELEASE."""
        self._boot = ack.boot
        if ack.status is not Status.DONE:
            self.seen = f"the target refused RELEASE, and says that it is {ack.state.name.lower()}"
        else:
            self.seen = wrong_state(ack)
        self.acknowledged = True

    def samples(self, samples: Samples) -> None:
        """A block that came; those from before the answer may have been under way."""
        if self.acknowledged and not self.seen and samples.boot == self._boot and shows_torque(samples.samples):
            what = "the wall on" if samples.samples.running.any() else "a torque"
            self.seen = f"the target acknowledged RELEASE, but goes on sending samples with {what}"
