"""Messages over a pipe between two processes: a length, then as many bytes."""

from typing import IO


def send(pipe: IO[bytes], message: bytes) -> None:
    """Send a message.

    Args:
        pipe: Where to.
        message: Its bytes.

    Raises:
        OSError: If nobody is there any more.
    """
    pipe.write(len(message).to_bytes(8, "big"))
    pipe.write(message)
    pipe.flush()


def received(pipe: IO[bytes]) -> bytes | None:
    """The next message.

    Args:
        pipe: Where from.

    Returns:
        Its bytes; None if the other end has gone, in the middle of it or before.
    """
    head = pipe.read(8)
    if len(head) < 8:
        return None
    length = int.from_bytes(head, "big")
    message = pipe.read(length)
    return message if len(message) == length else None
