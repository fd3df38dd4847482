"""The reference of drawings and checks is that of the program as it is."""

from hknob_cli.page.reference import reference
from tests.conftest import ROOT


def test_stored_reference_is_current() -> None:
    assert (ROOT / "docs" / "reference" / "page.md").read_text() == reference(), "make schemas"
