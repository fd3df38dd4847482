"""The strip an operator watches: grip against target, state of the trial, torque, time; and keys to steer it.

Keys pressed at a terminal, read without waiting for the end of a line.
"""

import contextlib
import os
import select
import sys
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from hknob_cli.hardware.trial_run import HANDS_OFF, Nobody, Operator, View, Wish
from hknob_cli.terminal import heed

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.live import Live

    from hknob_cli.specs.campaign import Course
    from hknob_cli.specs.pulses import PulseCourse

REFRESH_S = 0.1
WIDTH = 41  # of the gauge, odd so that the target is in its middle
_WISHES = {" ": Wish.END, "r": Wish.REPEAT, "q": Wish.STOP}
_SAID = {
    HANDS_OFF: "hands off the knob",
    "zero": "hands off: reading the empty grip cell",
    "grip": "grip the knob, into the band",
    "buzz": "buzzing: hold it",
    "rest": "at rest: hold it",
    "relax": "relax the hand",
    "squeeze": "squeeze slowly",
    "hold": "hold it",
    "pulse": "pulse",
    "release": "relax the hand",
    "done": "done",
}
_WITHOUT_CELL = {"zero": "hands off", "grip": "hold the knob"}


class Keys:
    """Keys as they are pressed; none where there is no terminal."""

    def __init__(self, descriptor: int | None) -> None:
        self._descriptor = descriptor

    def pressed(self, wait_s: float = 0.0) -> str:
        """The next key within a time, lower case; nothing if there is none.

        Raises `KeyboardInterrupt` where the terminal is gone, and with it whoever was there.
        """
        if self._descriptor is None:
            return ""
        ready, _, _ = select.select([self._descriptor], [], [], wait_s)
        if not ready:
            return ""
        try:
            found = os.read(self._descriptor, 1)
        except OSError:
            found = b""
        if not found:
            raise KeyboardInterrupt
        return found.decode("latin-1").lower()


@contextlib.contextmanager
def keys() -> Iterator[Keys]:
    """Keys of the terminal on stdin, which is as it was afterwards; Ctrl-C stays an interruption."""
    try:
        import termios
        import tty

        descriptor = sys.stdin.fileno()
        before = termios.tcgetattr(descriptor)
    except (ImportError, OSError, ValueError, AttributeError, termios.error):
        yield Keys(None)
        return
    try:
        tty.setcbreak(descriptor)
        yield Keys(descriptor)
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)


def gauge(grip_n: float | None, target_n: float, band_n: float) -> str:
    """The grip force as a mark on a scale from three bands below the target to three above; brackets are the band."""
    middle, step = WIDTH // 2, 6.0 * band_n / (WIDTH - 1)
    cells = ["-"] * WIDTH
    edge = round(band_n / step)
    cells[middle - edge], cells[middle + edge], cells[middle] = "[", "]", "|"
    if grip_n is not None:
        cells[min(max(middle + round((grip_n - target_n) / step), 0), WIDTH - 1)] = "#"
    return "".join(cells)


class Watching(Operator):
    """Shows the trial at hand, ten times a second at most, and hears keys where there are any."""

    def __init__(self, plan: "Course | PulseCourse", live: "Live | None", pressed: Keys, *, attended: bool) -> None:
        """``live`` draws; None draws nothing."""
        self._plan = plan
        self._live = live
        self._keys = pressed
        self._attended = attended
        self._drawn = -REFRESH_S

    def ready(self, view: View) -> Wish:
        """Wait for the space bar where somebody is there."""
        self._draw(view)
        while self._attended:
            heed()
            key = self._keys.pressed(REFRESH_S)
            if key == " ":
                break
            if key == "q":
                return Wish.STOP
        return Wish.GO_ON

    def look(self, view: View) -> Wish:
        """Draw if it is time, and say what key was pressed."""
        heed()
        if time.monotonic() - self._drawn >= REFRESH_S:
            self._draw(view)
        return _WISHES.get(self._keys.pressed(), Wish.GO_ON) if self._attended else Wish.GO_ON

    def _draw(self, view: View) -> None:
        self._drawn = time.monotonic()
        if self._live is not None:
            self._live.update(self._rendered(view), refresh=True)

    def _rendered(self, view: View) -> "RenderableType":
        from rich.text import Text

        plan, trial = self._plan, view.trial
        shown = plan.grip_of(trial.grip_target_n)
        held = view.grip_n is not None and (shown is None or abs(view.grip_n - shown.target) <= shown.band)
        force = "   -  " if view.grip_n is None else f"{view.grip_n:6.2f}"
        text = Text()
        text.append(f"trial {trial.number}/{view.trials}", style="bold")
        under = f", {trial.remedy}" if trial.remedy else ""
        where = f"{trial.grip_target_n:g} N" if trial.grip_target_n else f"{trial.counts_per_rev} counts{under}"
        text.append(f"  {trial.sample_rate_hz:g} Hz x {where}  ")
        said = (_SAID if shown else {**_SAID, **_WITHOUT_CELL}).get(view.state, view.state)
        said += ", then press space" if view.state == HANDS_OFF and self._attended else ""
        text.append(said, style="green" if view.state == "buzz" else "yellow")
        buzz = getattr(plan, "buzz", None)
        text.append(f"  {view.state_s:.1f} s of {buzz[1]:g}\n" if buzz and view.state == "buzz" else "\n")
        if shown:
            text.append(f"grip {force} N  ")
            text.append(gauge(view.grip_n, shown.target, shown.band), style="green" if held else "red")
            text.append(f"  target {shown.target:g} N\n")
        text.append(f"torque {1e3 * view.torque_nm:7.2f} mN m   time {view.running_s:5.1f} s")
        if self._attended:
            space = "space: begin" if view.state == HANDS_OFF else "space: end   r: again"
            text.append(f"   {space}   q: stop", style="dim")
        return text


@contextlib.contextmanager
def watching(plan: "Course | PulseCourse", *, attended: bool, show: bool) -> Iterator[Operator]:
    """Who watches: with a strip on stderr where ``show`` and it is a terminal, with keys where ``attended``."""
    if not show or not sys.stderr.isatty():
        yield Hearing()
        return
    from rich.console import Console
    from rich.live import Live

    with contextlib.ExitStack() as stack:
        pressed = stack.enter_context(keys()) if attended else Keys(None)
        drawn: Any = Live(console=Console(stderr=True), auto_refresh=False, transient=True)
        yield Watching(plan, stack.enter_context(drawn), pressed, attended=attended)


class Hearing(Nobody):
    """Nobody but the signals."""

    def look(self, _view: View) -> Wish:
        """Go on, unless interrupted."""
        heed()
        return Wish.GO_ON
