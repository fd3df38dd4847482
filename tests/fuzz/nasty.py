"""Values that a spec should not have, or just may have: scalars as YAML text, quantities, and texts."""

from random import Random

NUMBERS = (
    "0", "-0", "-0.0", "1", "-1", "0.5", "1.5", "2", "100", "1e3", "1.0e-3", "1e400", "-1e400", "1e-400",
    "5e-324", "1.7976931348623157e308", "-1.7976931348623157e308", "2.2250738585072014e-308", ".inf", "-.inf",
    ".nan", ".NaN", "nan", "inf", "+1", "1_000", "0x10", "0o17", "017", "0b11", "1:30", "1e", "--1", "1.", ".5",
    "1E+3", "1e+400", "2147483647", "2147483648", "2147483649", "4294967296", "9223372036854775807",
    "9223372036854775808", "18446744073709551616", "1e6", "1e9", "1e12", "1000001", "1e308", "0.1", "1e-9",
    "1e-308", "9" * 400, "9" * 5000, "1" + "0" * 308, "1" + "0" * 309, "0." + "0" * 400 + "1",
    "1e99999999999999999999",
)  # fmt: skip

SCALARS = (
    "null", "~", "", "true", "false", "True", "yes", "no", "on", "[]", "{}", "[1]", "[[]]", "{a: 1}",
    "[1, [2, {a: 3}]]", "2026-01-01", "2026-01-01T00:00:00Z", "=", "<<", "<<: 1", "*a", "&a 1", "&a", "!!str 1",
    "!!int 1.5", "!!float x", "!!null 1", "!!bool maybe", "!!binary aGVsbG8=", "!!set {a, b}", "!!omap [a: 1]",
    "!!timestamp 2026-13-45", "!!python/object/apply:os.system [true]", "!local 1", "!<tag:yaml.org,2002:int> 1",
    "!!map {}", "!!seq []", "|\n    text\n", ">\n    folded\n", "'", '"', "@", "`", "%", "- 1", "? a",
    "# comment", "a: b", "none", "'none'",
)  # fmt: skip

UNITS = (
    "Hz", "kHz", "GHz", "rad/s", "rpm", "1/s", "s", "ms", "min", "day", "kg", "g*cm^2", "kg*m^2", "kg m2",
    "g·cm²", "N", "mN", "N*m", "mN*m", "Nm", "N*m/rad", "N*m*s/rad", "N m s", "rad", "deg", "degree", "°", "m",
    "mm", "µm", "%", "count", "degC", "degF", "delta_degC", "dB", "dBm", "Pa", "Pa*s/rad", "m^99", "m^-99",
    "Hz^0", "yottahertz", "blargs", "e", "E5", "kg**2**2", "Hz/Hz", "Hz*(s", "((((Hz))))", "rad^2", "turn",
    "cycle", "parsec", "Ω", "dimensionless", "Δ", "lambda", "pi", "c", "hbar", "N*m/rad/0", "_", "in", "kHz/Hz",
    "Hz Hz Hz Hz", "bit", "mol", "eV", "ppm", "kkg", "µ", "μN·m",
)  # fmt: skip

AMOUNTS = ("1", "0", "-1", "1.5", "19.8", "0.27", "1e400", "1e-400", "1e308", "-0", "+1", "nan", ".5", "5.", "1_0")

TEXTS = (
    "", " ", "a", "x y", "Ä", "日本語", "😀", "e\u0301", "\ufeff", "\x00", "a\x00b", "\x07", "\x1b[31mred\x1b[0m",
    "\x1b]0;t\x07", "\x7f", "\x85", "\u2028", "\u202eevil\u202c", "\u2066a\u2069", "\u200b", "\ud800",
    "\udfff\ud800", "\udc80", "\U0010ffff", "\ufffe", "\r", "\n", "a\nb", "\t", "null", "true", "1", "1e3", "{x}",
    "{0}", "{", "}", "{x!r:>99999}", "%s%n", "$HOME", "~", "-", "--set", "=", "a=b", "a.b", "*", "**", "[", "]",
    "\\", "'", '"', "<script>alert(1)</script>", "&amp;", "#", ":", "x" * 100, "x" * 300, "x" * 5000, "é" * 200,
    "none", "None", "nan", "df0", "df999", "df1000", "all", "from", "kind",
)  # fmt: skip

PLACES = (
    "", ".", "..", "/", "~", "/dev/null", "/dev/zero", "/dev/full", "/dev/random", "/proc/self/mem",
    "/proc/self/environ", "/etc/passwd", "/etc", "pipe", "folder", "nowhere", "nowhere/at/all", "a\x00b",
    "\ud800", "x" * 300, "x/" * 3000, "spec.yaml", "grid", "conditions.parquet", "recordings.csv", "case.yaml",
    "claims.yaml", "loop", "../specs", "pipeline.yaml", "*.parquet", "\x1b[2J", "grid/cells.parquet",
    "torn.parquet", "empty.parquet", "text.parquet", "sweep.yaml", "unreadable", "hands",
)  # fmt: skip


def scalar(dice: Random) -> str:
    """A scalar, or a bit of YAML where one belongs."""
    return dice.choice(dice.choice((NUMBERS, NUMBERS, SCALARS)))


def quantity(dice: Random) -> str:
    """A number with a unit, of any kind or of none."""
    gap = dice.choice(("", " ", " ", "  ", "\t", "*", "\u00a0"))
    unit = dice.choice(UNITS)
    if dice.random() < 0.2:
        unit += dice.choice(("*", "/", " ", "^2 ")) + dice.choice(UNITS)
    return dice.choice(AMOUNTS) + gap + unit


def text(dice: Random) -> str:
    """A text, or where a file might be."""
    return dice.choice(TEXTS if dice.random() < 0.6 else PLACES)


def misspelt(word: str, dice: Random) -> str:
    """A word, one letter off."""
    at = dice.randrange(len(word) + 1)
    letter = dice.choice("abcdefghijklmnopqrstuvwxyz_.-0 \u0430")
    return dice.choice(
        (word[:at] + word[at + 1 :], word[:at] + letter + word[at:], word[:at] + letter + word[at + 1 :], word.upper())
    )
