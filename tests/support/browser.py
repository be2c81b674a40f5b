"""A browser that looks at a page as a reader does: headless Chromium, driven over a pipe.

Its DevTools protocol needs no library: a message is JSON, ended by a zero byte.
"""

import base64
import contextlib
import io
import json
import os
import pathlib
import select
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
"""What a machine may call it."""
PATIENCE = 60.0
"""Time after which a browser that says nothing is given up [s]."""


def executable() -> str | None:
    """The browser of this machine, None where there is none."""
    return next(filter(None, map(shutil.which, NAMES)), None)


class Page:
    """The one page of a browser."""

    def __init__(self, write: io.RawIOBase, read: io.RawIOBase) -> None:
        """A page that nothing is shown on yet.

        Args:
            write: The browser's ear.
            read: Its mouth.
        """
        self._write, self._read = write, read
        self._rest, self._number, self._session = b"", 0, None
        self.complaints: list[str] = []
        target = self._call("Target.createTarget", url="about:blank")["targetId"]
        attached = self._call("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self._call(f"{domain}.enable")

    def show(
        self,
        url: str,
        *,
        width: int,
        height: int = 900,
        dark: bool = False,
        paper: bool = False,
        still: bool = False,
    ) -> None:
        """Open an address on a screen, and wait until it is there.

        Args:
            url: The address.
            width: Width of the screen [px].
            height: Height of it [px].
            dark: Whether the reader prefers dark.
            paper: Whether it is laid out as for printing.
            still: Whether the reader prefers little motion.
        """
        self.complaints.clear()
        self._call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )
        self._call(
            "Emulation.setEmulatedMedia",
            media="print" if paper else "screen",
            features=[
                {"name": "prefers-color-scheme", "value": "dark" if dark else "light"},
                {"name": "prefers-reduced-motion", "value": "reduce" if still else ""},
            ],
        )
        self._call("Page.navigate", url=url)
        self.wait("document.readyState === 'complete'")

    def ask(self, expression: str) -> Any:
        """What an expression comes to on the page.

        Args:
            expression: JavaScript; a promise is waited for.

        Returns:
            Its value.

        Raises:
            RuntimeError: If it fails.
        """
        told = self._call(
            "Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True
        )
        if "exceptionDetails" in told:
            raise RuntimeError(str(told["exceptionDetails"]))
        return told["result"].get("value")

    def wait(self, condition: str, *, seconds: float = 20) -> None:
        """Wait until a condition holds on the page.

        Args:
            condition: JavaScript.
            seconds: How long at most [s].

        Raises:
            RuntimeError: If it doesn't come to hold.
        """
        tries = int(seconds / 0.05)
        pause = "new Promise(done => setTimeout(done, 50))"
        for _ in range(tries):
            if self.ask(f"Boolean({condition})"):
                return
            self.ask(pause)
        raise RuntimeError(f"after {seconds} s it still doesn't hold: {condition}")

    def screenshot(self, path: pathlib.Path, *, whole: bool = True) -> None:
        """Keep what is seen.

        Args:
            path: The picture, PNG.
            whole: Whether to show all of the page, or what is on the screen.
        """
        told = self._call("Page.captureScreenshot", captureBeyondViewport=whole)
        if whole:
            size = self._call("Page.getLayoutMetrics")["cssContentSize"]
            clip = {"x": 0, "y": 0, "scale": 1} | {k: size[k] for k in ("width", "height")}
            told = self._call("Page.captureScreenshot", captureBeyondViewport=True, clip=clip)
        path.write_bytes(base64.b64decode(told["data"]))

    def paper(self, path: pathlib.Path) -> None:
        """Print the page on A4.

        Args:
            path: The file, PDF.
        """
        told = self._call("Page.printToPDF", paperWidth=8.27, paperHeight=11.69)
        path.write_bytes(base64.b64decode(told["data"]))

    def _call(self, method: str, **parameters: Any) -> dict[str, Any]:
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session is not None:
            message["sessionId"] = self._session
        self._write.write(json.dumps(message).encode() + b"\0")
        while True:
            told = self._next()
            if told.get("id") == self._number:
                if "error" in told:
                    raise RuntimeError(f"{method}: {told['error']}")
                return told["result"]
            self._note(told)

    def _note(self, event: dict[str, Any]) -> None:
        method, parameters = event.get("method"), event.get("params", {})
        if method == "Runtime.exceptionThrown":
            self.complaints.append(str(parameters["exceptionDetails"]))
        if method == "Log.entryAdded" and parameters["entry"]["level"] == "error":
            self.complaints.append(parameters["entry"]["text"])

    def _next(self) -> dict[str, Any]:
        while b"\0" not in self._rest:
            if not select.select([self._read], [], [], PATIENCE)[0]:
                raise RuntimeError(f"the browser has said nothing for {PATIENCE:g} s")
            part = self._read.read(1 << 16)
            if not part:
                raise RuntimeError("the browser has gone")
            self._rest += part
        message, self._rest = self._rest.split(b"\0", 1)
        return json.loads(message)


@contextlib.contextmanager
def browser() -> Iterator[Page]:
    """A browser of its own, with nothing remembered.

    Yields:
        Its page.
    """
    to_browser, from_us = os.pipe()
    to_us, from_browser = os.pipe()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        process = subprocess.Popen(
            [
                # The protocol speaks on descriptors 3 and 4; `sh` knows none of two digits.
                "bash",
                "-c",
                f'exec "$0" "$@" 3<&{to_browser} 4>&{from_browser}',
                executable() or "chromium",
                "--headless=new",
                "--no-sandbox",
                "--disable-gpu",
                "--disable-dev-shm-usage",
                "--hide-scrollbars",
                "--remote-debugging-pipe",
                f"--user-data-dir={profile}",
            ],
            pass_fds=(to_browser, from_browser),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_browser)
        os.close(from_browser)
        try:
            with os.fdopen(from_us, "wb", 0) as ear, os.fdopen(to_us, "rb", 0) as mouth:
                yield Page(ear, mouth)
        finally:
            process.terminate()
            process.wait(timeout=20)
