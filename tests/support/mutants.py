"""Files that were damaged, or mean harm: drawn from good ones, by a seed."""

import random
import re

TOKEN = re.compile(rb"[A-Za-z_]\w*|[+-]?[\d.]+(?:[eE][+-]?\d+)?|\s+|.", re.DOTALL)

NASTY = (
    b"", b"0", b"-0", b"-1", b"1e308", b"-1e308", b"1e-308", b"1e999999999", b"nan", b"inf",
    b"-inf", b"NaN", b"9" * 400, b"0x" + b"f" * 300, b"1_000", b"1,5", b"1.5.2", b"null",
    b"true", b"[]", b"{}", b"[[", b"]]", b"{", b"}", b'"', b'"""', b"'", b"'''",
    b"\\", b"\\u0000",
    b"\x00", b"\x1b[31m", b"\x1b]0;x\x07", b"\xe2\x80\xae", b"\xff\xfe", b"\xef\xbb\xbf",
    b"\xed\xb2\x80", b"\xc3", b"\n", b"\r", b"\r\n", b"\n\n\n", b"@x", b"+1",
    b"=cmd|'/c calc'!A0",
    b"[bold]", b"[/nope]", b"<script>", b"../../etc/passwd", b"/dev/zero", b"/dev/stdin",
    b"a." * 60 + b"a", b"[" * 300, b"{a=" * 80, b" N" * 400, b"1 " + b"a" * 500, b"m^9" * 9,
    b"%", b"%s%n", b"${x}", b"{{ x }}", b"1979-05-27T07:32:00Z", b"dB", b"degC", b"1 m/s",
    b";", b"\t", b",,,,", b"#", b"x" * 20_000, b'"' + b"y" * 140_000 + b'"',
)  # fmt: skip
"""What takes a token's place."""


def mutant(content: bytes, seed: int) -> bytes:
    """A file with one to five changes: to bits, to pieces or to tokens."""
    draw = random.Random(seed)
    made = content
    for _ in range(draw.choice((1, 1, 1, 2, 3, 5))):
        made = draw.choice(CHANGES)(made or b"0", draw)
    return made


def _flipped(content, draw):
    made = bytearray(content)
    made[draw.randrange(len(made))] ^= 1 << draw.randrange(8)
    return bytes(made)


def _byte(content, draw):
    made = bytearray(content)
    made[draw.randrange(len(made))] = draw.choice((0, 1, 0x7F, 0x80, 0xFF, draw.randrange(256)))
    return bytes(made)


def _word(content, draw):
    """A size or an offset of four or eight bytes that is far off."""
    width = draw.choice((4, 8))
    number = draw.choice((0, 1, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, draw.randrange(2**32)))
    place = draw.randrange(len(content)) & ~3
    little = (number % 2 ** (8 * width)).to_bytes(width, "little")
    return content[:place] + little + content[place + width :]


def _cut(content, draw):
    return content[: draw.randrange(len(content))]


def _without(content, draw):
    first, last = _piece(content, draw)
    return content[:first] + content[last:]


def _twice(content, draw):
    first, last = _piece(content, draw)
    times = draw.choice((2, 2, 2, 50))
    return content[:first] + content[first:last] * times + content[last:]


def _moved(content, draw):
    first, last = _piece(content, draw)
    place = draw.randrange(len(content))
    return content[:place] + content[first:last] + content[place:]


def _piece(content, draw):
    first = draw.randrange(len(content))
    return first, min(len(content), first + draw.choice((1, 4, 16, 64, 256)))


def _token(content, draw):
    """A token, or a number, that is something else."""
    spans = [match.span() for match in TOKEN.finditer(content[:20_000])]
    first, last = draw.choice(spans)
    return content[:first] + draw.choice(NASTY) + content[last:]


def _number(content, draw):
    spans = [m.span() for m in re.finditer(rb"[\d.]+", content[:20_000])]
    if not spans:
        return _token(content, draw)
    first, last = draw.choice(spans)
    made = draw.choice((b"-" + content[first:last], b"0", b"1e6", b"1e300", b"-1e-300", b"7"))
    return content[:first] + made + content[last:]


def _swapped(content, draw):
    """Two tokens in each other's place."""
    spans = [match.span() for match in TOKEN.finditer(content[:20_000])]
    (a, b), (c, d) = sorted((draw.choice(spans), draw.choice(spans)))
    if c < b:
        return content
    return content[:a] + content[c:d] + content[b:c] + content[a:b] + content[d:]


CHANGES = (
    _flipped, _byte, _word, _cut, _without, _twice, _moved, _token, _token, _number, _swapped,
)  # fmt: skip
