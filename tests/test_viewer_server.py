import http.client
import socket
import threading

import pytest

from mien.errors import BadInput
from mien.viewer.server import LOCAL, PORT, Answer, Routes, open_server


@pytest.fixture(scope="module")
def server():
    routes = Routes()
    routes.get["/a"] = lambda asked: Answer(b"0123456789", "text/plain")
    routes.post["/keep"] = lambda body, asked: Answer(body[::-1])
    routes.post["/fault"] = lambda body, asked: refuse()
    server = open_server(routes)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield server
    server.shutdown()
    server.server_close()


def refuse():
    raise BadInput("it is wrong")


def ask(server, path, method="GET", body=None, **headers):
    line = http.client.HTTPConnection(LOCAL, server.server_port, timeout=10)
    line.request(method, path, body, headers)
    answer = line.getresponse()
    read = answer.status, answer.read(), answer.headers
    line.close()
    return read


def test_what_is_asked_for_with_the_token_comes(server):
    status, body, _ = ask(server, f"/a?token={server.token}")
    assert (status, body) == (200, b"0123456789")
    assert ask(server, f"/none?token={server.token}")[0] == 404


def test_parts_of_a_film_can_be_asked_for(server):
    status, body, headers = ask(server, f"/a?token={server.token}", Range="bytes=2-4")
    assert (status, body, headers["Content-Range"]) == (206, b"234", "bytes 2-4/10")
    assert ask(server, f"/a?token={server.token}", Range="bytes=-3")[1] == b"789"


@pytest.mark.parametrize(
    ("path", "headers"),
    [
        ("/a", {}),
        ("/a?token=guessed", {}),
        ("/a?token={token}", {"Origin": "http://elsewhere.example"}),
        ("/a?token={token}", {"Host": "elsewhere.example"}),
    ],
)
def test_strangers_are_refused(server, path, headers):
    assert ask(server, path.format(token=server.token), **headers)[0] == 403
    assert ask(server, path.format(token=server.token).replace("/a", "/keep"), "POST", b"x", **headers)[0] == 403


def test_what_is_saved_arrives_and_faults_are_told(server):
    assert ask(server, f"/keep?token={server.token}", "POST", b"abc")[1] == b"cba"
    status, body, _ = ask(server, f"/fault?token={server.token}", "POST", b"")
    assert (status, body) == (400, b"it is wrong")


def test_a_page_that_goes_away_disturbs_nobody(server):
    with socket.create_connection((LOCAL, server.server_port)) as line:
        line.sendall(b"GET /a HTTP/1.1\r\n")
    assert ask(server, f"/a?token={server.token}")[0] == 200


def test_a_port_in_use_gives_the_next_or_a_line(server):
    with open_server(Routes()) as other:
        assert other.server_port != server.server_port
    with pytest.raises(BadInput, match=f"--port {server.server_port}: .*in use"):
        open_server(Routes(), port=server.server_port)
    with pytest.raises(BadInput, match="cannot be listened on"):
        open_server(Routes(), host="no such host", port=PORT)
