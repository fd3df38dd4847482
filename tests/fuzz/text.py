"""Changes of a spec's text and bytes that know YAML, or nothing at all."""

from collections.abc import Callable
from random import Random

TOKENS = (
    "---\n", "...\n", "%YAML 1.1\n---\n", "%YAML 9.9\n---\n", "%YAML 1.9\n---\n",
    "%YAML 1.2\n---\n", "%TAG ! x\n", "&a ", "*a", "<<: ", "? ", ": ", "- ",
    "[", "]", "{", "}", ",", "#", "'", '"', "|", ">", "|9\n", ">-\n", "!!str ", "!", "\t", "\r", "\x85", "\u2028",
    "\ufeff", "\x00", "\x1b[1m", "\u202e", "\\", "\\x", "\\uD800", "@", "`", "\n\n", "\n ", " ", "null", "1e400",
    "\x07", "\ud7ff", "=", "\uffff", "é", "\U0001f600",
)  # fmt: skip
ODD_BYTES = (0, 9, 10, 13, 27, 34, 58, 127, 128, 192, 255)
NESTS = (("[", "]"), ("{a: ", "}"), ("- ", ""), ("{", "}"), ("? ", ""), ("[&a ", "]"), ("a: {", "}"))
PIECES = ("# c\n", "\n", " ", "x", "x: 1\n", "'", "\\n", "&a ", "-", "1", ",", "a ", "\t", "?\n", ": ", "!")


def change(text: str, dice: Random) -> bytes:
    """The bytes of a text with one change."""
    return dice.choice(CHANGES)(text, dice)


def _token(text: str, dice: Random) -> bytes:
    """Something of YAML's own, anywhere."""
    for _ in range(dice.choice((1, 1, 2, 5))):
        at = dice.randrange(len(text) + 1)
        text = text[:at] + dice.choice(TOKENS) + text[at:]
    return _coded(text)


def _lines(text: str, dice: Random) -> bytes:
    """A line moved, missing, doubled, or at another indentation."""
    lines = text.splitlines(keepends=True) or [""]
    at, other = dice.randrange(len(lines)), dice.randrange(len(lines))
    match dice.randrange(5):
        case 0:
            lines.insert(other, lines.pop(at))
        case 1:
            del lines[at]
        case 2:
            lines.insert(at, lines[at])
        case 3:
            lines[at] = dice.choice((" ", "  ", "\t")) + lines[at]
        case 4:
            lines[at] = lines[at][dice.choice((1, 2)) :]
    return _coded("".join(lines))


def _endings(text: str, dice: Random) -> bytes:
    return _coded(text.replace("\n", dice.choice(("\r\n", "\r", "\x85", "\u2028", "\n\n", "", " \n"))))


def _encoding(text: str, dice: Random) -> bytes:
    """Another encoding, or a mark of one."""
    match dice.randrange(5):
        case 0:
            return b"\xef\xbb\xbf" * dice.choice((1, 1, 2)) + _coded(text)
        case 1:
            return text.encode("utf-16", errors="replace")
        case 2:
            return text.encode("utf-16-le", errors="replace")
        case 3:
            return text.encode("utf-32", errors="replace")
    return (text + "# é").encode("latin-1", errors="replace")


def _torn(text: str, dice: Random) -> bytes:
    data = _coded(text)
    return data[: dice.randrange(len(data) + 1)]


def _documents(text: str, dice: Random) -> bytes:
    """Two documents, or one after itself."""
    return _coded(text + dice.choice(("---\n", "...\n", "--- \n", "\n")) + dice.choice((text, "kind: sweep\n", "x")))


def _bytes(text: str, dice: Random) -> bytes:
    """Bytes changed, lost, new or doubled."""
    data = bytearray(_coded(text))
    for _ in range(dice.choice((1, 1, 2, 8, 64))):
        at = dice.randrange(len(data) + 1)
        match dice.randrange(4):
            case 0 if at < len(data):
                data[at] ^= 1 << dice.randrange(8)
            case 1:
                del data[at : at + dice.choice((1, 1, 4, 50))]
            case 2:
                data[at:at] = bytes(dice.choice(ODD_BYTES) for _ in range(dice.choice((1, 3))))
            case 3:
                data[at:at] = data[at : at + 20]
    return bytes(data)


def _deep(text: str, dice: Random) -> bytes:
    """Nesting without end, in the place of the last value or of everything."""
    count = dice.choice((30, 49, 51, 200, 1200, 20_000))
    opening, closing = dice.choice(NESTS)
    inner = opening * count + dice.choice(("1", "", "*a")) + closing * dice.choice((count, count, 0, count + 1))
    return _coded((text.rstrip("\n").rpartition(":")[0] + ": " if dice.random() < 0.8 else "") + inner + "\n")


def _long(text: str, dice: Random) -> bytes:
    """Much of something: comments, blank lines, one word, one scalar, or keys."""
    count = dice.choice((100, 3000, 10_000))
    piece = dice.choice(PIECES)
    at = dice.choice((0, len(text), dice.randrange(len(text) + 1)))
    return _coded(text[:at] + piece * count + text[at:])


def _aliases(text: str, dice: Random) -> bytes:
    """A few lines that mean billions."""
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [" + ", ".join([f"*a{i - 1}"] * 8) + "]" for i in range(1, dice.choice((2, 2, 2, 2, 4, 9)))]
    return _coded("\n".join(lines) + "\n" + text)


def _coded(text: str) -> bytes:
    return text.encode("utf-8", errors="surrogatepass")


CHANGES: tuple[Callable[[str, Random], bytes], ...] = (
    *(_token,) * 5, *(_lines,) * 4, *(_bytes,) * 5, _endings, _encoding, *(_torn,) * 2, _documents, _deep, _long,
    _aliases,
)  # fmt: skip
