"""The page's server: Python's own, on this machine alone unless told otherwise.

Every address bears a token that only the page that was opened knows, and requests that a page of another origin sends
are refused. Threads: two viewers at once, and a page that closes in the middle of an answer, disturb nobody.
"""

import json
import secrets
import socket
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import parse_qs, urlsplit

from ..errors import BadInput
from .page_files import static

LOCAL = "127.0.0.1"
"""This machine alone."""

PORT = 8360
"""Where the page is looked for first."""

PORTS_TRIED = 20
"""Ports from the first one on that are tried where it is taken."""

CHUNK = 1 << 18
"""Bytes written at once."""

LARGEST_REQUEST = 64 << 20
"""Bytes that a page may send."""

MIMES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".json": "application/json",
    ".mp4": "video/mp4",
    ".webm": "video/webm",
    ".mov": "video/quicktime",
    ".jpg": "image/jpeg",
    ".png": "image/png",
}


@dataclass(frozen=True)
class Answer:
    """What goes back to the page."""

    body: bytes
    mime: str = "application/octet-stream"
    status: int = HTTPStatus.OK

    @classmethod
    def json(cls, told: Mapping[Any, Any]) -> "Answer":
        """What a page reads as an object."""
        return cls(json.dumps(told).encode(), MIMES[".json"])

    @classmethod
    def stale(cls, why: str) -> "Answer":
        """A save that rests on what another page has changed since."""
        return cls(why.encode(), "text/plain", HTTPStatus.CONFLICT)


Get = Callable[[Mapping[str, str]], Answer]
Post = Callable[[bytes, Mapping[str, str]], Answer]


@dataclass
class Routes:
    """What the page can ask for, by path, beside its own files."""

    get: dict[str, Get] = field(default_factory=dict)
    post: dict[str, Post] = field(default_factory=dict)
    stream: dict[str, Callable[[Callable[[bytes], None], Mapping[str, str]], None]] = field(default_factory=dict)
    """Answers without an end: called with what writes to the page, until that raises `OSError`."""


class PageServer(ThreadingHTTPServer):
    """Serves one page."""

    daemon_threads = True
    allow_reuse_address = False

    def __init__(self, routes: Routes, host: str = LOCAL, port: int = PORT):
        self.routes, self.token = routes, secrets.token_urlsafe(18)
        self.host = host
        super().__init__((host, port), _Handler)

    @property
    def address(self) -> str:
        """What to open."""
        shown = LOCAL if self.host in ("", "0.0.0.0") else self.host
        return f"http://{shown}:{self.server_port}/?token={self.token}"

    def handle_error(self, request, client_address) -> None:
        """A page that went away is no fault."""


def open_server(routes: Routes, host: str = LOCAL, port: int | None = None) -> PageServer:
    """Listen on `port`, or on the first free one from `PORT` on.

    Raises:
        BadInput: the port is taken, or the host is not this machine's.
    """
    tried = range(PORT, PORT + PORTS_TRIED) if port is None else [port]
    for number in tried:
        try:
            return PageServer(routes, host, number)
        except (socket.gaierror, OverflowError) as error:
            raise BadInput(f"--host {host} --port {number}: cannot be listened on: {error}") from error
        except OSError as error:
            fault = error
    if port is None:
        return PageServer(routes, host, 0)
    raise BadInput(f"--port {port}: {fault.strerror}; leave --port out to have a free one")


class _Handler(BaseHTTPRequestHandler):
    server: PageServer
    protocol_version = "HTTP/1.1"
    timeout = 60

    def do_GET(self) -> None:
        """The page, its files, and what `Routes` knows."""
        path, asked = self._asked()
        routes = self.server.routes
        if path in ("/studio.js", "/studio.css", "/studio.LICENSE"):
            return self._send(Answer(static(path[1:]), MIMES.get(path[path.rfind(".") :], "text/plain")))
        if not self._allowed(asked):
            return None
        if path == "/":
            return self._send(Answer(static("studio.html"), MIMES[".html"]))
        if path in routes.stream:
            return self._stream(routes.stream[path], asked)
        if path in routes.get:
            return self._send(_told(lambda: routes.get[path](asked)))
        return self._send(Answer(b"no such thing", "text/plain", HTTPStatus.NOT_FOUND))

    def do_POST(self) -> None:
        """What the page saves."""
        path, asked = self._asked()
        if not self._allowed(asked):
            return None
        length = int(self.headers.get("Content-Length", 0))
        if path not in self.server.routes.post or length > LARGEST_REQUEST:
            self.close_connection = True
            return self._send(Answer(b"no such thing", "text/plain", HTTPStatus.NOT_FOUND))
        body = self.rfile.read(length)
        return self._send(_told(lambda: self.server.routes.post[path](body, asked)))

    def log_message(self, format: str, *args) -> None:
        """Nothing is printed."""

    def _asked(self) -> tuple[str, dict[str, str]]:
        parts = urlsplit(self.path)
        return parts.path, {name: values[-1] for name, values in parse_qs(parts.query).items()}

    def _allowed(self, asked: Mapping[str, str]) -> bool:
        """The token is right, and no page of another origin asks."""
        origin, host = self.headers.get("Origin"), self.headers.get("Host", "")
        told = asked.get("token") or self.headers.get("X-Token") or ""
        same = origin in (None, f"http://{host}")
        known = self.server.host in ("", "0.0.0.0") or urlsplit(f"//{host}").hostname in (self.server.host, "localhost")
        if same and known and secrets.compare_digest(told.encode(), self.server.token.encode()):
            return True
        self.close_connection = True
        text = b"this page belongs to another run of `mien view`; open the address that it printed"
        self._send(Answer(text, "text/plain", HTTPStatus.FORBIDDEN))
        return False

    def _send(self, answer: Answer) -> None:
        body, first, status = answer.body, 0, answer.status
        span = self.headers.get("Range", "")
        last = len(body) - 1
        if status == HTTPStatus.OK and span.startswith("bytes=") and body:
            begin, _, end = span[6:].split(",")[0].partition("-")
            first = int(begin) if begin else max(len(body) - int(end or 0), 0)
            last = min(int(end), last) if begin and end else last
            status = HTTPStatus.PARTIAL_CONTENT if first <= last else HTTPStatus.REQUESTED_RANGE_NOT_SATISFIABLE
        self.send_response(status)
        self.send_header("Content-Type", answer.mime)
        self.send_header("Content-Length", str(last - first + 1))
        self.send_header("Accept-Ranges", "bytes")
        self.send_header("Cache-Control", "no-store")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Content-Security-Policy", "frame-ancestors 'none'")
        if status == HTTPStatus.PARTIAL_CONTENT:
            self.send_header("Content-Range", f"bytes {first}-{last}/{len(body)}")
        self.end_headers()
        for at in range(first, last + 1, CHUNK):
            self.wfile.write(body[at : min(at + CHUNK, last + 1)])

    def _stream(self, source, asked: Mapping[str, str]) -> None:
        self.close_connection = True
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", "application/octet-stream")
        self.send_header("Cache-Control", "no-store")
        self.send_header("Connection", "close")
        self.end_headers()

        def write(data: bytes) -> None:
            self.wfile.write(data)
            self.wfile.flush()

        try:
            source(write, asked)
        except OSError:
            return


def _told(ask: Callable[[], Answer]) -> Answer:
    """The answer, or what was wrong with the question."""
    try:
        return ask()
    except (BadInput, ValueError, OSError) as error:
        return Answer(str(error).encode(), "text/plain; charset=utf-8", HTTPStatus.BAD_REQUEST)
