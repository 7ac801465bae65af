"""The monitor's page is for this computer's browser alone, whatever comes to its port."""

import contextlib
import http.client
import json
import re
import socket
import struct
import threading

import pytest

from larics.wire import messages as m
from larics_host import local_server
from larics_host.monitor import web
from larics_host.monitor.session import Session
from larics_host.monitor.state import MonitorState
from tests.host.test_log import marker_values, wire
from tests.host.waiting import PATIENCE_S


class Camera:
    """A live source that says nothing and counts what is sent to it."""

    live = True

    def __init__(self):
        self.name = "camera"
        self.asked = threading.Event()
        self._come = [wire((m.MARKER, marker_values(1)))]

    def read(self):
        return self._come.pop() if self._come else b""

    def write(self, data):
        pass

    def close(self):
        pass


@pytest.fixture
def server(monkeypatch):
    monkeypatch.setattr(local_server, "_TIMEOUT_S", 60)  # of a computer that stands still meanwhile
    session = Session(Camera(), MonitorState("camera"))
    session.asked = 0

    def fetch_raw():
        session.asked += 1
        return True

    session.fetch_raw = fetch_raw
    server = web.serve(session, 0)
    yield server
    server.shutdown()
    server.server_close()


def connect(server):
    return socket.create_connection(("127.0.0.1", server.server_port), timeout=PATIENCE_S)


def exchange(server, data):
    """Everything that the server answers to these bytes until it closes the connection."""
    with connect(server) as link:
        link.sendall(data)
        answer = b""
        with contextlib.suppress(ConnectionResetError):
            while part := link.recv(65536):
                answer += part
    return answer


def statuses(answer):
    return [int(code) for code in re.findall(rb"HTTP/1\.[01] (\d+)", answer)]


SECOND = b"POST /frame HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 0\r\n\r\n"


@pytest.mark.parametrize(
    "first, code",
    [
        (b"POST /frame HTTP/1.1\r\nHost: 127.0.0.1\r\nOrigin: http://evil.example\r\n%s\r\n", 403),
        (b"POST /frame HTTP/1.1\r\nHost: evil.example\r\n%s\r\n", 403),
        (b"POST /nothing HTTP/1.1\r\nHost: 127.0.0.1\r\n%s\r\n", 404),
        (b"GET /nothing HTTP/1.1\r\nHost: 127.0.0.1\r\n%s\r\n", 404),
        (b"GET /frame.png HTTP/1.1\r\nHost: 127.0.0.1\r\n%s\r\n", 404),
        (b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n%s\r\n", 200),
        (b"PUT /frame HTTP/1.1\r\nHost: 127.0.0.1\r\n%s\r\n", 501),
        (b"HEAD / HTTP/1.1\r\nHost: 127.0.0.1\r\n%s\r\n", 501),
        (b"GET http://evil.example/ HTTP/1.1\r\nHost: 127.0.0.1\r\n%s\r\n", 404),
        (b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nHost: evil.example\r\n%s\r\n", 403),
        (b"GET / HTTP/9.9\r\nHost: 127.0.0.1\r\n%s\r\n", 505),
    ],
)
@pytest.mark.parametrize(
    "body",
    [
        b"Content-Length: %d\r\n" % len(SECOND),
        b"Content-Length: 0\r\n",
        b"Content-Length: many\r\n",
        b"Transfer-Encoding: chunked\r\n",
        b"Content-Length: 5\r\nTransfer-Encoding: chunked\r\n",
        b"Connection: keep-alive\r\nContent-Length: %d\r\n" % len(SECOND),
    ],
)
def test_no_body_is_taken_for_a_second_request(server, first, body, code):
    answer = exchange(server, first % body + SECOND)
    assert statuses(answer)[:1] in ([code], [])  # none when the answer was overtaken by the end
    assert len(statuses(answer)) <= 1 and server.content.asked == 0


def test_a_refusal_reaches_who_sent_a_large_body(server):
    head = b"POST /frame HTTP/1.1\r\nHost: 127.0.0.1\r\nOrigin: null\r\nContent-Length: 50000\r\n\r\n"
    assert statuses(exchange(server, head + bytes(50000))) == [403]


def test_plain_requests_may_follow_each_other(server):
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=PATIENCE_S)
    for _ in range(3):
        connection.request("GET", "/")
        answer = connection.getresponse()
        assert answer.status == 200 and b"LARICS monitor" in answer.read()
        assert "frame-ancestors 'none'" in answer.headers["Content-Security-Policy"]
    connection.close()


@pytest.mark.parametrize(
    "host, origin, code",
    [
        ("127.0.0.1:{port}", None, 202),
        ("127.0.0.1:{port}", "http://127.0.0.1:{port}", 202),
        ("localhost:{port}", "http://localhost:{port}", 202),
        ("LocalHost:{port}", "HTTP://LOCALHOST:{port}", 202),
        ("[::1]:{port}", "http://[::1]:{port}", 202),
        ("[::1]", None, 202),
        ("localhost:9000", "http://localhost:9000", 202),  # through a tunnel
        ("127.0.0.1:{port}", "http://127.0.0.1:{other}", 403),  # another program's page on this computer
        ("127.0.0.1:{port}", "http://127.0.0.1", 403),
        ("127.0.0.1:{port}", "http://localhost:{port}", 403),
        ("127.0.0.1:{port}", "https://127.0.0.1:{port}", 403),
        ("127.0.0.1:{port}", "null", 403),
        ("127.0.0.1:{port}", "http://evil.example", 403),
        ("127.0.0.1:{port}", "http://evil.example/127.0.0.1:{port}", 403),
        ("evil.example:{port}", None, 403),
        ("localhost.evil.example", "http://localhost.evil.example", 403),
        ("[::1].evil.example", None, 403),
        ("[::2]:{port}", None, 403),
        ("[", None, 403),
        ("", None, 403),
        (None, None, 403),
    ],
)
def test_origin_must_equal_a_host_that_is_this_computer(server, host, origin, code):
    ports = {"port": server.server_port, "other": server.server_port ^ 1}
    head = "POST /frame HTTP/1.1\r\n"
    head += "" if host is None else "Host: %s\r\n" % host.format(**ports)
    head += "" if origin is None else "Origin: %s\r\n" % origin.format(**ports)
    answer = exchange(server, head.encode() + b"Connection: close\r\n\r\n")
    assert statuses(answer) == [code] and server.content.asked == (code == 202)


@pytest.mark.parametrize(
    "head",
    [
        b"",
        b"GET / HT",
        b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX-Slow: ",
        b"POST /frame HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 1000\r\n\r\n",
    ],
)
def test_who_is_slow_is_cut_off_however_it_drips(server, monkeypatch, head):
    monkeypatch.setattr(local_server, "_TIMEOUT_S", 0.3)
    with connect(server) as link:
        link.sendall(head)
        stop = threading.Event()

        def drip():
            while not stop.wait(0.05):
                with contextlib.suppress(OSError):
                    link.sendall(b"x")

        thread = threading.Thread(target=drip)
        thread.start()
        try:
            with contextlib.suppress(ConnectionResetError):
                while link.recv(65536):  # a time-out here would be the server's failure
                    pass
        finally:
            stop.set()
            thread.join()


def test_connections_are_capped_and_come_free_again(server, monkeypatch):
    links = [connect(server) for _ in range(local_server.CONNECTIONS)]
    for link in links:  # each has a thread of its own as soon as it is answered
        link.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        assert link.recv(12) == b"HTTP/1.1 200"
    assert statuses(exchange(server, b"")) == [503]
    for link in links:
        link.close()
    request = b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n"
    while statuses(exchange(server, request)) != [200]:  # until the threads have noticed
        pass


def test_a_browser_that_goes_away_leaves_no_trace(server, capfd):
    for data in (b"", b"GET / HTTP/1.1\r\nHost:", b"GET /events HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"):
        with connect(server) as link:
            link.sendall(data)
            if b"events" in data:
                assert link.recv(12) == b"HTTP/1.1 200"
            link.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # closes by a reset
    # all threads have ended when all places are free
    for _ in range(local_server.CONNECTIONS):
        assert server._free.acquire(timeout=PATIENCE_S)
    out, err = capfd.readouterr()
    assert (out, err) == ("", "")


def test_a_fault_of_our_own_is_one_line(server, capfd):
    server.content.fetch_raw = lambda: 1 // 0
    exchange(server, b"POST /frame HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
    err = capfd.readouterr().err
    assert err.count("\n") == 1 and "could not answer a request: ZeroDivisionError" in err


def test_events_go_on_over_many_pages(server):
    links = [connect(server) for _ in range(4)]
    server.content.start()
    for link in links:
        link.sendall(b"GET /events HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
    for link in links:
        file = link.makefile("rb")
        while not (line := file.readline()).startswith(b"data: "):
            assert line
        assert json.loads(line.removeprefix(b"data: "))["source"] == "camera"
        file.close()
        link.close()
    server.content.stop()
