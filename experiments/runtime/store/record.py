"""A unit's result as a file: bound to what it follows from, and to every bit of it."""

import hashlib

_MARK = b"scdpr unit 1\n"
_HASH = 32


def sealed(identity: bytes, content: bytes) -> bytes:
    """A result with its seal.

    Args:
        identity: Hash of everything that the result depends on.
        content: The result.

    Returns:
        What a file of it holds.
    """
    return _MARK + identity + hashlib.sha256(identity + content).digest() + content


def opened(identity: bytes, record: bytes) -> bytes:
    """A result from its file.

    Args:
        identity: Hash of everything that the result shall depend on.
        record: What the file holds.

    Returns:
        The result.

    Raises:
        ValueError: If it isn't whole, or another's; says which.
    """
    begin, middle = len(_MARK), len(_MARK) + _HASH
    found, seal = record[begin:middle], record[middle : middle + _HASH]
    content = record[middle + _HASH :]
    if not record.startswith(_MARK) or hashlib.sha256(found + content).digest() != seal:
        raise ValueError("damaged")
    if found != identity:
        raise ValueError("of other inputs, or another unit's")
    return content
