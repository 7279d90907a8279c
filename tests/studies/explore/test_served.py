"""Only pages of this server are answered, and no path leads to another file."""

import json
from http.client import HTTPConnection
from urllib.parse import urlsplit

import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

import apesim
from apesim.engine.machine import Machine
from apesim.studies.explore.app import ASSETS
from tests.studies.explore.conftest import decode

ASKED = {"number": 4, "values": {"speed": "1200 rpm", "engine.bore": "90 mm"}}
OK, FORBIDDEN, MISSING = 200, 403, 404


class Client:
    """What asks the server for something, under any name and from any page."""

    def __init__(self, address):
        self.place = urlsplit(address).netloc
        self.port = int(self.place.rpartition(":")[2])
        self.origin = f"http://{self.place}"

    def ask(self, path, host=None, origin=None, body=None):
        """Status, headers and text of an answer; a body is posted."""
        connection = HTTPConnection("127.0.0.1", self.port, timeout=30)
        connection.putrequest("GET" if body is None else "POST", path, skip_host=True, skip_accept_encoding=True)
        for name, value in (("Host", self.place if host is None else host), ("Origin", origin)):
            if value is not None:
                connection.putheader(name, value)
        if body is not None:
            connection.putheader("Content-Length", str(len(body)))
        connection.endheaders(body)
        answer = connection.getresponse()
        found = answer.status, {name.lower(): value for name, value in answer.getheaders()}, answer.read().decode()
        connection.close()
        return found

    def post(self, path, body=None, origin=None, host=None):
        """Status, headers and text of what is answered to a request of the page."""
        content = json.dumps(ASKED).encode() if body is None else body
        return self.ask(path, host, self.origin if origin is None else origin, content)

    def open_session(self, origin=None):
        """WebSocket of a session."""
        return connect(f"ws://{self.place}/session", origin=origin, open_timeout=30, max_size=None, proxy=None)


@pytest.fixture(scope="module")
def client(address):
    return Client(address)


def test_the_page_and_its_assets_are_served_with_nothing_from_elsewhere(client):
    for path in ASSETS:
        status, headers, text = client.ask(path)
        assert status == OK and text
        assert "default-src 'none'" in headers["content-security-policy"]
        assert "nosniff" in headers["x-content-type-options"]
    page = client.ask("/")[2]
    assert "http://" not in page and "https://" not in page
    assert all(f'"{path}"' in page for path in ASSETS if path != "/")


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:{port}", "127.0.0.1", "127.0.0.1:1", "", "127.0.0.1:{port}.x"]
)
def test_a_foreign_host_is_refused(client, host):
    for path in ("/", "/start.json"):
        assert client.ask(path, host.format(port=client.port))[0] == FORBIDDEN


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "https://127.0.0.1:{port}", "http://127.0.0.1:1"])
def test_a_foreign_origin_is_refused(client, origin):
    origin = origin.format(port=client.port)
    assert client.ask("/start.json", origin=origin)[0] == FORBIDDEN
    assert client.post("/machine.toml", origin=origin)[0] == FORBIDDEN
    with pytest.raises(InvalidStatus) as refused, client.open_session(origin):
        pass
    assert refused.value.response.status_code == FORBIDDEN


def test_who_does_not_say_where_from_opens_no_session_and_posts_nothing(client):
    assert client.ask("/command", body=json.dumps(ASKED).encode())[0] == FORBIDDEN
    with pytest.raises(InvalidStatus), client.open_session():
        pass


def test_localhost_is_this_computer_too(client):
    name = f"localhost:{client.port}"
    assert client.ask("/", name)[0] == OK
    assert client.post("/command", origin=f"http://{name}", host=name)[0] == OK
    assert client.post("/command", host=name)[0] == FORBIDDEN


@pytest.mark.parametrize(
    "path",
    ["/../app.py", "/..%2fapp.py", "/%2e%2e/app.py", "/assets/explore.js", "//etc/passwd", "/explore.js/../app.py"],
)
def test_no_path_leads_to_another_file(client, path):
    assert client.ask(path)[0] == MISSING


def test_a_session_answers_with_the_number_of_the_request(client):
    with client.open_session(client.origin) as socket:
        socket.send(json.dumps(ASKED))
        header, curves = decode(socket.recv(timeout=120))
        while header["kind"] == "compiling":
            header, curves = decode(socket.recv(timeout=120))
    assert (header["kind"], header["number"]) == ("point", 4)
    assert header["own"]["speed_rpm"] == 1200.0
    assert len(curves["lift"]) == 361


def test_the_machine_is_saved_as_a_file_that_gives_the_same_one(client, tmp_path):
    _, headers, text = client.post("/machine.toml")
    assert 'filename="mine.toml"' in headers["content-disposition"]
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    assert apesim.Machine.load(path) == Machine().with_(engine_bore="90 mm")


def test_the_command_gives_the_same_machine_and_speed(client):
    command = json.loads(client.post("/command")[2])["command"]
    assert command == "apesim engine run --speed '1200 rpm' --set 'engine.bore=90 mm'"


@pytest.mark.parametrize(
    ("body", "status"),
    [(b"{", 400), (b"x" * 70_000, 413), (b'{"number": 1, "values": {"engine.bore": "9 km"}}', 422)],
)
def test_a_body_that_cannot_be_is_told(client, body, status):
    told, _, text = client.post("/machine.toml", body)
    assert told == status
    assert status != 422 or {fault["key"] for fault in json.loads(text)["faults"]} >= {"engine.bore"}


def test_a_report_is_opened_under_a_name_that_nobody_guesses(client):
    status, _, text = client.post("/report")
    assert status == OK
    name = json.loads(text)["address"]
    status, headers, page = client.ask(name)
    assert status == OK and page.startswith("<!doctype html>") and "90 mm" in page
    assert "connect-src" not in headers["content-security-policy"]
    assert client.ask("/report/other")[0] == MISSING
    assert client.ask(name, origin="http://evil.example")[0] == FORBIDDEN


def test_commands_are_corrected_to_the_angles_of_the_ideal_valve(client):
    status, _, text = client.post("/timing")
    assert status == OK
    values = json.loads(text)["values"]
    keys = {key: values[key] for key in ("command.energise", "command.release")}
    run = apesim.run_engine(Machine().with_(engine_bore="90 mm", **keys), "1200 rpm")
    assert (run["valve_open_deg"], run["valve_close_deg"]) == pytest.approx((-5.0, 70.0), abs=0.1)


def test_a_timing_out_of_reach_is_told(client):
    weak = {"number": 1, "values": {"speed": "2400 rpm", "supply.control_pressure": "0.01 MPa gauge"}}
    status, _, text = client.post("/timing", json.dumps(weak).encode())
    assert status == 422 and json.loads(text)["faults"][0]["right"]
