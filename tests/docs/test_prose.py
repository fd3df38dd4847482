"""The rules of prose: what each finds, what it lets pass, and how a finding is printed."""

from pathlib import Path

import pytest

from .house_style import LONGEST, off_in
from .prose import findings, main

LONG = "The knob meets " + " and ".join(f"wall{number}" for number in range(20)) + "."  # 42 words
STIFF = {
    "The cycles are proven, but for those with friction.": "house.plain",
    "A file of one's own works, too.": "house.plain",
    "The cache is not used, for it is not the user's.": "house.because",
    "Nothing is kept there, for the whole folder is removed at the end.": "house.because",
    "What is not listed does not exist.": "house.subject_first",
    "A sweep writes files. Of many cells a few are drawn.": "house.subject_first",
    "Friction is left out. So is a finger.": "house.subject_first",
    "The sampling rate is 1 kHz.": "house.words",
    "The deadband holds it.": "house.words",
    LONG: "house.length",
    "It goes on for ever.": "archaism",
    "The the wall is stiff.": "lexical_illusions",
}
PLAIN = [
    "The cycles are proven. The exception is friction.",
    "A table has a column for the hand that gains least.",
    "The time for a cell is printed, for each cell that has one.",
    "What does it cost? Two seconds.",
    "Of the 79 cycles, 12 are large.",
    "Of course it buzzes.",
    "The sample rate is 1 kHz.",
    "The hand holds the knob in a pinch, as `for it is` and `sampling rate` say.",
    "# What is proven, and what is not",
    "[What goes with what](page.md) is the whole table.",
    "| one | two |\n|---|---|\n| the wall | the wall |",
    "```text\n" + LONG + "\n```",
    "The axes are " + ", ".join(["`knob.inertia`"] * (LONGEST + 1)) + ".",
    LONG.replace("wall9 and", "wall9. And"),
]


@pytest.mark.parametrize("text", STIFF)
def test_stiff_sentences_are_found(text: str) -> None:
    assert [found.rule for found in findings(text + "\n", ("house.short",))] == [STIFF[text]]


@pytest.mark.parametrize("text", PLAIN)
def test_plain_sentences_pass(text: str) -> None:
    assert findings(text + "\n") == []


def test_a_rule_can_be_off_in_a_page() -> None:
    assert findings("The sampling rate.\n", ("house.words",)) == []


def test_newcomers_get_shorter_sentences() -> None:
    text = "The knob meets " + " and ".join(f"wall{number}" for number in range(15)) + ".\n"  # 32 words
    assert [found.rule for found in findings(text, off_in("docs/tutorials/your_knob.md"))] == ["house.short"]
    assert findings(text, off_in("docs/reference/wire.md")) == []


def test_a_finding_has_its_place(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In a folder, in a table, and in the second line of a paragraph."""
    page = tmp_path / "page.md"
    page.write_text(
        "# Title\n\nA sentence on `code`\nand the deadband.\n\n| one |\n|---|\n| for ever |\n", encoding="utf-8"
    )
    assert main([str(tmp_path)]) == 1
    assert capsys.readouterr().out.splitlines() == [
        f"{page}:4: house.words: write 'dead band', not 'deadband'",
        f"{page}:8: archaism: 'for ever' is archaic.",
    ]


def test_a_page_without_findings_is_silent(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = tmp_path / "page.md"
    page.write_text("The knob rests.\n", encoding="utf-8")
    assert main([str(page)]) == 0
    assert capsys.readouterr().out == ""
