"""A small web server for one page, a stream of events and commands: without ROS, and careful whom it listens to.

Commands need a token, which stands in the address behind #, where no server or log sees it. The name that a browser
asks for and the page that sends a command are checked, so that no other page can use this one's place.
"""

import contextlib
import functools
import hmac
import ipaddress
import queue
import secrets
import socket
import threading
from collections.abc import Callable, Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import urlsplit

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.base.report import parse_json

MOST_VIEWERS = 32
MOST_CONNECTIONS = 64
LARGEST_COMMAND = 4096  # B
REQUEST_TIME = 10.0  # s for a whole request to come in
PATIENCE = 10.0  # s for a viewer to take what is sent
WAITING = 20  # events that a slow viewer may be behind; then the oldest are dropped
ASK_AGAIN = 2  # s after which a browser requests a page again that was not ready
QUIET = 2.0  # s without an event after which a sign of life is sent: a viewer that has left is noticed then
SAFE_HEADERS = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
}


class RequestRefused(BearingTwinError):
    """A request that is answered with `status` and one sentence."""

    def __init__(self, status: HTTPStatus, sentence: str):
        super().__init__(sentence)
        self.status = status


class Feed:
    """Events for any number of viewers: each is encoded once, and a viewer that is too slow misses some."""

    def __init__(self):
        self._lock = threading.Lock()
        self._viewers: set[queue.Queue] = set()

    @property
    def viewers(self) -> int:
        """Number of viewers."""
        return len(self._viewers)

    def join(self) -> queue.Queue:
        """A new viewer's events; raises RequestRefused where there are MOST_VIEWERS."""
        with self._lock:
            if len(self._viewers) >= MOST_VIEWERS:
                raise RequestRefused(
                    HTTPStatus.SERVICE_UNAVAILABLE, f"{MOST_VIEWERS} viewers are the most there may be"
                )
            events: queue.Queue = queue.Queue(WAITING)
            self._viewers.add(events)
            return events

    def leave(self, events: queue.Queue) -> None:
        """The viewer has gone."""
        with self._lock:
            self._viewers.discard(events)

    def send(self, name: str, data: str) -> None:
        """One event of one line to all viewers."""
        event = f"event: {name}\ndata: {data}\n\n".encode()
        with self._lock:
            for events in self._viewers:
                if events.full():
                    events.get_nowait()
                events.put_nowait(event)


class PageServer(ThreadingHTTPServer):
    """Serves a `site` on `host` and `port` (0: any that is free); raises BearingTwinError where it cannot listen.

    A site has a `feed`, `page()`, which gives HTML, and `execute(command)`, which gives one sentence; both may raise
    BearingTwinError.
    """

    daemon_threads = True
    block_on_close = False

    def __init__(self, site, host: str, port: int):
        self.site, self.token = site, secrets.token_urlsafe(24)
        self._host = host
        self._connections = threading.BoundedSemaphore(MOST_CONNECTIONS)
        self.stopping = threading.Event()
        if ":" in host:
            self.address_family = socket.AF_INET6
        try:
            super().__init__((host, port), _Handler)
        except (OSError, OverflowError) as error:
            why = getattr(error, "strerror", None) or error
            raise BearingTwinError(f"nothing can listen on {host}:{port} ({why}); give another --port") from error

    @property
    def url(self) -> str:
        """The address with the token that commands need."""
        host = f"[{self._host}]" if ":" in self._host else self._host
        return f"http://{host}:{self.server_port}/#{self.token}"

    def start(self) -> None:
        """Serves in a thread of its own."""
        threading.Thread(target=self.serve_forever, kwargs={"poll_interval": 0.2}, name="serve", daemon=True).start()

    def close(self) -> None:
        """Ends it; viewers are left alone."""
        self.stopping.set()
        self.shutdown()
        self.server_close()

    def is_served_host(self, host: str) -> bool:
        """True if a browser may use this host name: a page elsewhere could resolve its own name to this server."""
        name = urlsplit(f"//{host}").hostname or ""
        if name in ("localhost", self._host.lower()):
            return True
        try:
            return ipaddress.ip_address(name).is_loopback or not _is_loopback(self._host)
        except ValueError:
            return False

    def process_request(self, request, client_address):
        """A thread for each connection, up to MOST_CONNECTIONS of them."""
        if not self._connections.acquire(blocking=False):
            self.shutdown_request(request)
            return
        super().process_request(request, client_address)

    def process_request_thread(self, request, client_address):
        """One connection."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._connections.release()

    def handle_error(self, request, client_address):
        """Nothing: connections may break."""


class _Handler(BaseHTTPRequestHandler):
    server: PageServer
    timeout = PATIENCE
    server_version, sys_version = "bearing_twin", ""

    def log_message(self, *_):
        """Nothing: a page sends many requests."""

    def handle(self):
        """One request; its connection ends if it has not come in after REQUEST_TIME, however slowly it comes."""
        self._limit = threading.Timer(REQUEST_TIME, self._expire)
        self._limit.daemon = True
        self._limit.start()
        try:
            super().handle()
        finally:
            self._limit.cancel()

    def _expire(self) -> None:
        with contextlib.suppress(OSError):
            self.connection.shutdown(socket.SHUT_RDWR)

    def do_GET(self):
        """The page, or its events."""
        no_icon = functools.partial(self._send, HTTPStatus.NO_CONTENT, "image/x-icon", b"")
        self._answer({"/": self._page, "/events": self._events, "/favicon.ico": no_icon})

    def do_POST(self):
        """A command."""
        self._answer({"/command": self._command})

    def _answer(self, routes: Mapping[str, Callable[[], None]]) -> None:
        if self.command == "GET":
            self._limit.cancel()
        try:
            if not self.server.is_served_host(self.headers.get("Host", "")):
                raise RequestRefused(
                    HTTPStatus.FORBIDDEN, "this host name is not served: use the address that was printed"
                )
            respond = routes.get(urlsplit(self.path).path)
            if respond is None:
                raise RequestRefused(HTTPStatus.NOT_FOUND, "there is nothing here: the page is at /")
            respond()
        except RequestRefused as error:
            self._send_sentence(error.status, str(error))
        except BearingTwinError as error:
            self._send_sentence(HTTPStatus.CONFLICT, str(error))
        except (OSError, ValueError):  # the connection broke, or what came over it was no request
            self.close_connection = True

    def _page(self) -> None:
        try:
            self._send(HTTPStatus.OK, "text/html; charset=utf-8", self.server.site.page())
        except BearingTwinError as error:  # it may be there soon
            status = error.status if isinstance(error, RequestRefused) else HTTPStatus.SERVICE_UNAVAILABLE
            self._send(status, "text/plain; charset=utf-8", f"{error}\n".encode(), Refresh=str(ASK_AGAIN))

    def _events(self) -> None:
        self._check_origin()
        waiting = self.server.site.feed.join()
        try:
            self._head(HTTPStatus.OK, "text/event-stream; charset=utf-8")
            self.end_headers()
            while not self.server.stopping.is_set():
                try:
                    event = waiting.get(timeout=QUIET)
                except queue.Empty:
                    event = b": waiting\n\n"
                self.wfile.write(event)
        finally:
            self.close_connection = True
            self.server.site.feed.leave(waiting)

    def _command(self) -> None:
        self._check_origin()
        token = self.headers.get("X-Token", "")
        if not hmac.compare_digest(token.encode(), self.server.token.encode()):
            raise RequestRefused(HTTPStatus.FORBIDDEN, "commands need the token that the printed address ends with")
        length = self.headers.get("Content-Length", "")
        if not length.isdecimal() or int(length) > LARGEST_COMMAND:
            raise RequestRefused(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"a command has at most {LARGEST_COMMAND} bytes")
        try:
            command = parse_json(self.rfile.read(int(length)))
        except ValueError:
            raise RequestRefused(HTTPStatus.BAD_REQUEST, "a command is one JSON object") from None
        if not isinstance(command, dict):
            raise RequestRefused(HTTPStatus.BAD_REQUEST, "a command is one JSON object")
        self._send_sentence(HTTPStatus.OK, self.server.site.execute(command))

    def _check_origin(self) -> None:
        """Refuses requests of pages of another origin than this one, which is the host name of the request."""
        origin = self.headers.get("Origin")
        if origin is not None and origin != f"http://{self.headers.get('Host', '')}":
            raise RequestRefused(HTTPStatus.FORBIDDEN, "requests of other pages are refused")
        if self.headers.get("Sec-Fetch-Site", "same-origin") not in ("same-origin", "none"):
            raise RequestRefused(HTTPStatus.FORBIDDEN, "requests of other pages are refused")

    def _send_sentence(self, status: HTTPStatus, sentence: str) -> None:
        self._send(status, "text/plain; charset=utf-8", f"{sentence}\n".encode())

    def _head(self, status: HTTPStatus, kind: str, **headers: str) -> None:
        self.send_response(status)
        for name, value in {**SAFE_HEADERS, "Content-Type": kind, **headers}.items():
            self.send_header(name, value)

    def _send(self, status: HTTPStatus, kind: str, content: bytes, **headers: str) -> None:
        self._head(status, kind, **headers)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
