"""Places that a sentence names."""

import pytest

from hknob_cli.page.claims.ledger import places


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("Sec. 6.4.2, Table 7, Figs 33-35", ["6.4.2", "Figure 33", "Figure 34", "Figure 35", "Table 7"]),
        ("Sec. 6.4.2; sec. 10.2, item 7", ["6.4.2", "10.2", "10.2, item 7"]),
        ("sections 4.2.1 and 4.3", ["4.2.1", "4.3"]),
        ("sections 6.3-6.4\n(Fig. 27, Table 7)", ["6.3", "6.4", "Figure 27", "Table 7"]),
        ("Appendices A to C, App. D; Appendix A.1", ["A", "B", "C", "D", "A.1"]),
        ("Abstract; ch. 12", ["abstract", "12"]),
        ("Figs 29, 30, 33-34, and 38", [f"Figure {one}" for one in (29, 30, 33, 34, 38)]),
        ("Table 1, 14.2 N, 0.71 N; Fig. 35.", ["Figure 35", "Table 1"]),
        ("Chapter 8's cells, Tables 1 to 3", ["8", "Table 1", "Table 2", "Table 3"]),
        ("secs. 6.2 and 9.1): Hasser, eq. 1; a", ["6.2", "9.1", "Equation 1"]),
        ("Sec. 7.2, u'(t); sec. 7.2", ["7.2"]),
        ("Boiko, eq. 4.20; 20 seconds; 4 sections; a table 100 mm wide", []),
    ],
)
def test_places(text: str, named: list[str]) -> None:
    assert list(places(text)) == named
