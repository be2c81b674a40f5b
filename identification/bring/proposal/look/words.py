"""What names say: which words stand for which column, in the tongues of labs."""

import re
from collections.abc import Sequence

CONCEPTS: dict[str, frozenset[str]] = {
    name: frozenset(words.split())
    for name, words in {
        "t": "t time times timestamp stamp stamps zeit zeitstempel temps tempo tiempo tijd tid "
        "clock elapsed tout xvalue datetime date uhrzeit seconds sec msec micros millis",
        "voltage": "u v volt volts voltage voltages spannung spannungen tensione voltaje cmd "
        "command commands ctrl control ao dac out output uout ucmd vcmd pwm stellgroesse "
        "stellgröße sollspannung setvolt drivecmd",
        "alpha": "enc encoder encoders alpha angle angles winkel ctr counter counters count "
        "counts cnt ticks inc inkremente position positions pos theta phi rot shaft drehgeber "
        "resolver motorangle pulley a n ang",
        "current": "i cur curr current currents strom amps ampere iq courant corriente",
        "tension": "tension tensions force forces kraft load loadcell seilkraft zug",
        "ref": "ref reference soll sollwert des desired target setpoint sp traj cmdpos",
        "x_e": "x xe ex xpos posx xee",
        "y_e": "y ye ey ypos posy yee",
        "delta_e": "delta theta phi rot rotation angle winkel yaw tilt psi drehung orientation "
        "orient deltae ang neigung roll heading",
        "carriage": "q carriage carriages cart carts slider sliders wagen schlitten carr slide "
        "laufwagen trolley",
        "accelerometer": "a acc accel acceleration accelerometer beschleunigung imu adxl",
    }.items()
}
"""Words of each concept, in lower case."""

CAMERA = frozenset(
    [
        "cam",
        "camera",
        "kamera",
        "pose",
        "poses",
        "vision",
        "tracker",
        "tracking",
        "track",
        "marker",
        "image",
        "frame",
        "frames",
        "mocap",
        "ee",
        "eff",
        "effector",
        "endeffector",
        "tcp",
        "tool",
        "platform",
        "body",
        "optitrack",
        "video",
        "plattform",
    ]
)
"""Words of the vision system, in a name or above it."""
LOWER = frozenset(
    ["lower", "low", "bottom", "unten", "lo", "down", "3", "l", "q3", "untere", "unterer"]
)
"""Words of the lower carriage."""
UPPER = frozenset(
    ["upper", "high", "top", "oben", "hi", "up", "4", "u", "q4", "obere", "oberer"]
)
"""Words of the upper one."""
FIRST = frozenset(["left", "links", "l", "a", "eins", "first", "one", "gauche"])
"""Words of the first of two that aren't numbers."""
SECOND = frozenset(["right", "rechts", "r", "b", "zwei", "second", "two", "droite"])
"""Words of the second."""
INDEX = frozenset(
    [
        "index",
        "idx",
        "sample",
        "samples",
        "nr",
        "no",
        "num",
        "row",
        "count",
        "n",
        "i",
        "zeile",
        "frame",
        "frameno",
    ]
)
"""Words of a column that counts its rows."""

_PARTS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-zäöüß]+|\d+")


def tokens(name: str) -> tuple[str, ...]:
    """The words of a name, in lower case.

    Args:
        name: A name such as "Motor1 Voltage", "u_left", "q3".

    Returns:
        Its words and numbers: ("motor", "1", "voltage").
    """
    return tuple(part.lower() for part in _PARTS.findall(name))


def says(name: str, concept: str) -> float:
    """How much a name says that it is a concept's.

    Args:
        name: The name, without its unit.
        concept: One of `CONCEPTS`.

    Returns:
        0 for nothing, up to 3 for a word that means nothing else.
    """
    words, told = tokens(name), CONCEPTS[concept]
    joined = "".join(words)
    if joined in told or "".join(w for w in words if not w.isdecimal()) in told:
        return 3.0 if len(joined) > 2 else 2.5
    hits = [word for word in words if word in told]
    if not hits:
        return 0.0
    return 3.0 if max(map(len, hits)) > 2 else 1.5


def place(names: Sequence[str]) -> list[int]:
    """The order of two or more names that differ in a number or a side.

    Args:
        names: The names.

    Returns:
        Their places in the order that numbers and sides give them.
    """
    keys = [_key(name, names) for name in names]
    return sorted(range(len(names)), key=lambda k: (keys[k], k))


def _key(name: str, names: Sequence[str]) -> tuple[int, int]:
    """A name's number or side, by what it doesn't share with the others."""
    words = [set(tokens(each)) for each in names]
    own = [word for word in tokens(name) if not all(word in each for each in words)]
    for word in own:
        if word.isdecimal():
            return (0, int(word))
    for word in own:
        if word in FIRST | SECOND:
            return (1, int(word in SECOND))
    return (2, 0)
