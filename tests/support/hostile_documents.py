"""JSON documents in which something can't be, drawn at random."""

import copy
import json

import numpy as np

HOSTILE = (
    -1.0, 0.0, -0.0, 1e-30, 1e30, -1e30, 1e308, float("nan"), float("inf"), float("-inf"),
    None, True, "1.0", "NaN", "", [], [1.0], {}, {"value": 1.0}, "kg", 7, -3,
)  # fmt: skip
"""What takes the place of a number, a word or a list."""


def places(document, path=()):
    """Every place in a document, as the keys that lead to it."""
    inner = document.items() if isinstance(document, dict) else enumerate(document)
    for key, content in inner:
        yield (*path, key)
        if isinstance(content, dict | list):
            yield from places(content, (*path, key))


def hostile(document, random):
    """The text of a document in which one to three places are something else, or are gone."""
    made = copy.deepcopy(document)
    for _ in range(random.integers(1, 4)):
        everywhere = list(places(made))
        *above, key = everywhere[random.integers(len(everywhere))]
        parent = made
        for step in above:
            parent = parent[step]
        _change(parent, key, random)
    return json.dumps(made)


def _change(parent, key, random):
    content, kind = parent[key], random.random()
    if kind < 0.2:
        del parent[key]
    elif kind < 0.3 and isinstance(parent, list):
        parent.insert(0, content)
    elif kind < 0.5 and isinstance(content, float):
        # Another unit, or a sign.
        parent[key] = content * random.choice([-1.0, 1e3, 1e-3, 1e6, 1e-6, 57.3, 1e12])
    else:
        parent[key] = HOSTILE[random.integers(len(HOSTILE))]


def outcomes(read, document, path, *, seed, draws, judge=lambda content: None):
    """What comes of reading draws: the reason, or None where the content is judged sound."""
    random, made = np.random.default_rng(seed), []
    for _ in range(draws):
        path.write_text(hostile(document, random))
        try:
            content = read(path)
        except ValueError as error:
            made.append(str(error))
        else:
            judge(content)
            made.append(None)
    return made
