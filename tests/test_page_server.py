"""The server of live pages: who may look, who may command, and what a hostile or slow visitor can do."""

import contextlib
import http.client
import socket
import time
from types import SimpleNamespace

import pytest

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.view import page_server
from bearing_twin.view.page_server import Feed, PageServer

PATIENCE = 300.0  # s: what does not come about at all fails, slowness does not


def a_site():
    """A page, its feed, and what was commanded."""
    executed = []

    def execute(command):
        if command.get("do") == "fail":
            raise BearingTwinError("it cannot be done")
        executed.append(command)
        return "done"

    return SimpleNamespace(feed=Feed(), executed=executed, page=lambda: b"<p>page</p>", execute=execute)


@pytest.fixture
def server():
    served = PageServer(a_site(), "127.0.0.1", 0)
    served.start()
    yield served
    served.close()


def ask(server, method="GET", path="/", body=None, host=None, **headers):
    """(status, text, headers) of an answer."""
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=PATIENCE)
    named = {"Host": host} if host else {}
    try:
        connection.request(method, path, body, {key.replace("_", "-"): value for key, value in headers.items()} | named)
        answer = connection.getresponse()
        return answer.status, answer.read().decode(), answer.headers
    finally:
        connection.close()


def command(server, body='{"do": "reset"}', **headers):
    return ask(server, "POST", "/command", body, **{"X_Token": server.token, **headers})


def test_the_page_is_served_with_headers_that_keep_it_to_itself(server):
    status, text, headers = ask(server)
    assert (status, text) == (200, "<p>page</p>")
    assert {name: headers[name] for name in page_server.SAFE_HEADERS} == page_server.SAFE_HEADERS
    assert "Python" not in headers["Server"]

    def page():
        raise BearingTwinError("it comes soon")

    server.site.page = page
    status, text, headers = ask(server)  # and the browser asks again
    assert (status, text, headers["Refresh"]) == (503, "it comes soon\n", str(page_server.ASK_AGAIN))


def test_a_command_with_the_token_of_this_page_is_executed(server):
    host = f"127.0.0.1:{server.server_port}"
    for headers in ({}, {"Origin": f"http://{host}", "Sec_Fetch_Site": "same-origin"}):
        assert command(server, **headers)[:2] == (200, "done\n")
    assert server.site.executed == [{"do": "reset"}] * 2
    assert command(server, '{"do": "fail"}')[:2] == (409, "it cannot be done\n")
    assert server.url == f"http://{host}/#{server.token}"  # behind the hash no server or log sees it
    second_server = PageServer(a_site(), "127.0.0.1", 0)
    assert second_server.token != server.token
    assert len(server.token) >= 32
    with pytest.raises(BearingTwinError, match=r"\(Address already in use\); give another --port"):
        PageServer(a_site(), "127.0.0.1", second_server.server_port)
    second_server.server_close()


def test_without_the_token_nothing_is_executed(server):
    for token in ("", "x", "é", None):
        headers = {} if token is None else {"X_Token": token.encode()}
        status, text, _ = ask(server, "POST", "/command", '{"do": "reset"}', **headers)
        assert status == 403
        assert "commands need the token" in text
    assert server.site.executed == []


def test_other_pages_are_refused_even_with_the_token_and_names_that_lead_here_from_elsewhere(server):
    origins, sites = ("http://evil.example", "null"), ("cross-site", "same-site")
    for name, value in (*(("Origin", origin) for origin in origins), *(("Sec_Fetch_Site", site) for site in sites)):
        assert command(server, **{name: value})[:2] == (403, "requests of other pages are refused\n")
        assert ask(server, path="/events", **{name: value})[0] == 403
    assert server.site.executed == []
    for host, status in {"localhost:80": 200, "[::1]:1": 200, "evil.example": 403, "10.0.0.1": 403, " ": 403}.items():
        assert ask(server, host=host)[0] == status
    server._host = "0.0.0.0"  # one that listens for others answers to its addresses
    assert ask(server, host="10.0.0.1:8080")[0] == 200
    assert ask(server, host="evil.example")[0] == 403


def test_what_is_no_command_or_no_request_is_answered_with_one_sentence_or_ends_quietly(server):
    for body, status in {"[]": 400, "{": 400, "[" * 4000: 400, "x" * (page_server.LARGEST_COMMAND + 1): 413}.items():
        answered, text, _ = command(server, body)
        assert answered == status
        assert len(text.splitlines()) == 1
    assert server.site.executed == []
    assert ask(server, path="/../../etc/passwd")[0] == 404
    assert ask(server, "POST", "/")[0] == 404
    with socket.create_connection(("127.0.0.1", server.server_port), timeout=PATIENCE) as raw:
        raw.sendall(b"\x00\xff\r\n\r\n")
        raw.recv(1000)
    assert ask(server)[0] == 200


def listened(server, path="/events"):
    """A connection on which events come."""
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=PATIENCE)
    connection.request("GET", path)
    return connection, connection.getresponse()


def until(done):
    end = time.monotonic() + PATIENCE
    while not done():
        time.sleep(0.01)
        assert time.monotonic() < end


def test_all_viewers_get_the_events_and_are_counted_up_to_a_limit(server, monkeypatch):
    monkeypatch.setattr(page_server, "QUIET", 0.2)
    monkeypatch.setattr(page_server, "MOST_VIEWERS", 3)
    feed = server.site.feed
    viewers = [listened(server) for _ in range(3)]
    until(lambda: feed.viewers == 3)
    status, text, _ = ask(server, path="/events")
    assert status == 503
    assert "the most there may be" in text
    feed.send("frames", "abc")
    for _, answer in viewers:
        lines = []
        while len(lines) < 2:
            lines += [line for line in [answer.readline()] if line.strip() and not line.startswith(b":")]
        assert lines == [b"event: frames\n", b"data: abc\n"]
    for connection, answer in viewers:
        answer.close()
        connection.close()
    until(lambda: feed.viewers == 0)


def test_a_slow_viewer_misses_the_oldest_events_and_holds_up_nobody():
    feed = Feed()
    slow = feed.join()
    for number in range(1000):
        feed.send("frames", str(number))
    assert slow.qsize() == page_server.WAITING
    assert slow.get_nowait() == f"event: frames\ndata: {1000 - page_server.WAITING}\n\n".encode()


def test_connections_that_say_nothing_or_little_at_a_time_take_only_so_many_places(monkeypatch):
    monkeypatch.setattr(page_server, "MOST_CONNECTIONS", 4)
    monkeypatch.setattr(page_server, "REQUEST_TIME", 0.5)
    server = PageServer(a_site(), "127.0.0.1", 0)
    server.start()
    idle = [socket.create_connection(("127.0.0.1", server.server_port), timeout=PATIENCE) for _ in range(6)]

    def said_little():
        for connection in idle[:3]:
            with contextlib.suppress(OSError):
                connection.send(b"G")
        return ask_or_none(server) == 200

    until(said_little)  # once the time for a request is over
    for connection in idle:
        connection.close()
    server.close()


def ask_or_none(server):
    try:
        return ask(server)[0]
    except (OSError, http.client.HTTPException):
        return None
