"""The page in a tab of its own, with what it asks for and complains of."""

from typing import Any

WIDE, PHONE = {"width": 1280, "height": 900}, {"width": 360, "height": 740}


class Opened:
    """The page in a tab of its own, with what it asked for and complained of."""

    def __init__(self, browser: Any, address: str, *, at: str = "", **options: Any) -> None:
        self.context = browser.new_context(offline=True, **{"viewport": WIDE, **options})
        self.context.set_default_timeout(120_000)  # computers are busy
        self.tab = self.context.new_page()
        self.asked: list[str] = []
        self.said: list[str] = []
        self.tab.on("request", lambda request: self.asked.append(request.url))
        self.tab.on("console", lambda message: self.said.append(message.text))
        self.tab.on("pageerror", lambda error: self.said.append(str(error)))
        self.tab.goto(address + at)

    def unfold(self) -> "Opened":
        """Open every chapter, as a reader would who wants them all."""
        self.tab.eval_on_selector_all(".fold", "all => { for (const one of all) one.open = true; }")
        return self

    def __enter__(self) -> "Opened":
        return self

    def __exit__(self, *_: object) -> None:
        self.context.close()
