"""A folder of results on this machine's own address, which is only read.

A page of another site that a browser shows can ask this address too, under a name of its own
that it makes point here. So the name that is asked for has to be this machine's, only GET is
answered, and nothing that is asked for changes anything.
"""

import dataclasses
import http.server
import importlib.resources
import pathlib
from collections.abc import Callable
from urllib.parse import parse_qsl, unquote, urlsplit

from experiments.reports.show import pages
from experiments.reports.show.asked_leg import asked_leg
from experiments.reports.show.planned import Planning
from experiments.reports.show.results import REPORT, Results
from scdpr_jax.provenance import made_today
from tuning.plan.plan_file import plan_table

ADDRESS = "127.0.0.1"
"""This machine's own address: no other machine reaches it."""
_NAMES = (ADDRESS, "localhost")
"""What a browser may call it."""
_PATIENCE = 10.0
"""How long a connection may say nothing [s]."""
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; "
_HEADERS = {
    "Content-Security-Policy": _POLICY
    + "script-src 'self'; connect-src 'self'; form-action 'self'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


@dataclasses.dataclass(frozen=True)
class Answer:
    """What is answered."""

    body: bytes
    """The content."""
    kind: str = "text/html; charset=utf-8"
    """Its type."""
    status: int = 200
    """Its status."""
    name: str = ""
    """The file that it is to be kept as; empty for a page."""


class Show:
    """What is answered to what is asked."""

    def __init__(self, results: Results) -> None:
        """Nothing has been asked.

        Args:
            results: The folder.
        """
        self._results = results
        self.planning = Planning(results.tuning) if pages.can_plan(results) else None

    def answer(self, target: str) -> Answer:
        """What is answered to a target.

        Args:
            target: Path and query, as a browser asks for them.

        Returns:
            A page, a file, or why there is none.
        """
        parts = urlsplit(target)
        query = dict(parse_qsl(parts.query, keep_blank_values=True))
        path = unquote(parts.path)
        if path.startswith("/files/"):
            return self._file(path.removeprefix("/files/"))
        make = self._routes().get(path)
        if make is None:
            return _missing("There is no such page.")
        try:
            return make(query)
        except ValueError as reason:
            return Answer(pages.problem(str(reason)).encode(), status=400)

    def _routes(self) -> dict[str, Callable[[dict[str, str]], Answer]]:
        """Every page that this folder has."""
        results, planning = self._results, self.planning
        routes = {
            "/": lambda query: _page(pages.overview(results)),
            "/show.js": lambda query: Answer(_script(), "text/javascript; charset=utf-8"),
        }
        if REPORT in results.files:
            routes["/report"] = lambda query: Answer(results.files[REPORT].read_bytes())
        if results.runs and results.robot is not None:
            routes["/runs"] = lambda query: _page(pages.run_page(results, query))
        if planning is not None:
            routes |= {
                "/plan": lambda query: _page(pages.plan_page(results, planning, query)),
                "/plan/leg": lambda query: _page(
                    pages.tried(planning, asked_leg(query, results.tuning))
                ),
                "/plan/page": lambda query: _page(pages.leg_page(results, planning, query)),
                "/plan.csv": self._plan,
            }
        return routes

    def _plan(self, query: dict[str, str]) -> Answer:
        """A leg's references and feed-forward."""
        tuning = self._results.tuning
        made = self.planning.plan(asked_leg(query, tuning))
        of = made_today(tuning.provenance.campaign, tuning.provenance.source)
        text = plan_table(made.plan, marked=bool(tuning.caution), provenance=of)
        return Answer(text.encode(), "text/csv; charset=utf-8", name="plan.csv")

    def _file(self, name: str) -> Answer:
        path = self._results.files.get(name)
        if path is None:
            return _missing("There is no such file.")
        return Answer(path.read_bytes(), "application/octet-stream", name=path.name)


def server(folder: Results, *, port: int = 0) -> tuple[http.server.ThreadingHTTPServer, Show]:
    """What serves a folder, once it is told to.

    Args:
        folder: The folder.
        port: Port; 0 for any that is free.

    Returns:
        The server, which listens, and what answers.

    Raises:
        OSError: If the port is taken.
    """
    show = Show(folder)

    class Handler(_Handler):
        answers = show

    http.server.ThreadingHTTPServer.daemon_threads = True
    return http.server.ThreadingHTTPServer((ADDRESS, port), Handler), show


class _Handler(http.server.BaseHTTPRequestHandler):
    """A connection."""

    answers: Show
    timeout = _PATIENCE
    server_version, sys_version = "scdpr", ""

    def do_GET(self) -> None:
        if not self._is_ours():
            self._send(_refused())
            return
        try:
            answer = self.answers.answer(self.path)
        except OSError as reason:
            words = f"{pathlib.Path(reason.filename or '').name}: {reason.strerror}"
            answer = _missing(f"A file can't be read any more: {words}.")
        self._send(answer)

    def log_message(self, format: str, *arguments: object) -> None:
        """Says nothing: the terminal keeps the address in sight."""

    def _is_ours(self) -> bool:
        """Whether the browser asks for this machine by its own name."""
        hosts = self.headers.get_all("Host", [])
        port = self.server.server_address[1]
        return len(hosts) == 1 and hosts[0].lower() in {f"{name}:{port}" for name in _NAMES}

    def _send(self, answer: Answer) -> None:
        self.send_response(answer.status)
        for name, text in _HEADERS.items():
            self.send_header(name, text)
        self.send_header("Content-Type", answer.kind)
        self.send_header("Content-Length", str(len(answer.body)))
        if answer.name:
            safe = "".join(letter if letter.isalnum() else "_" for letter in answer.name[:-4])
            safe += answer.name[-4:] if answer.name[-4:].replace(".", "").isalnum() else ""
            self.send_header("Content-Disposition", f'attachment; filename="{safe}"')
        self.end_headers()
        try:
            self.wfile.write(answer.body)
        except (BrokenPipeError, ConnectionResetError):
            # Whoever asked has gone.
            self.close_connection = True


def _page(text: str) -> Answer:
    return Answer(text.encode())


def _missing(text: str) -> Answer:
    return Answer(pages.problem(text).encode(), status=404)


def _refused() -> Answer:
    text = "This address answers only to the name of this machine itself."
    return Answer(text.encode(), "text/plain; charset=utf-8", 403)


def _script() -> bytes:
    folder = importlib.resources.files("experiments.page") / "templates"
    return (folder / "show.js").read_bytes()
