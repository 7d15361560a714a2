"""Where the workbench's server listens, and where it refuses to."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from workbench_fake import FILES, FakeSession, fetch

from feeler.errors import OptionError
from feeler.workbench.net.listening import Place
from feeler.workbench.net.server import Server


@pytest.fixture
def session() -> FakeSession:
    return FakeSession()


@pytest.fixture
def server(session: FakeSession) -> Iterator[Server]:
    with Server(session, files=FILES) as server:
        yield server


def test_it_listens_on_loopback_alone(server: Server) -> None:
    at = urlsplit(server.url)
    listening = server._listening
    assert listening is not None
    assert {each.getsockname()[0] for each in listening.sockets} <= {"127.0.0.1", "::1"}
    assert {each.getsockname()[1] for each in listening.sockets} == {at.port}


def test_both_addresses_of_loopback_answer(server: Server) -> None:
    port = urlsplit(server.url).port
    listening = server._listening
    assert listening is not None
    if len(listening.sockets) < 2:
        pytest.skip("no IPv6 here")
    assert fetch(f"http://[::1]:{port}/", "/")[0] == 200


def test_a_port_in_use_is_said(server: Server, session: FakeSession) -> None:
    with pytest.raises(OptionError, match="in use"):
        Server(session, files=FILES, port=urlsplit(server.url).port or 0).start()


@pytest.mark.parametrize(
    ("place", "words"),
    [
        (Place(port=65_536), "from 0"),
        (Place(port=-1), "from 0"),
        (Place(host="192.168.1.2"), "allow remote access if that is meant"),
        (Place(host="0.0.0.0"), "allow remote access if that is meant"),
        (Place(host="box.example", allow_remote=True), "needs TLS"),
        (Place(host="0.0.0.0", allow_remote=True, certificate=Path("c"), key=Path("k")), "which is any"),
        (Place(certificate=Path("c")), "give both"),
        (Place(allow_remote=True), "no host is given"),
    ],
)
def test_places_that_are_refused(session: FakeSession, place: Place, words: str) -> None:
    with pytest.raises(OptionError, match=words):
        Server(session, files=FILES, place=place)


def test_tls_files_that_are_none(session: FakeSession, tmp_path: Path) -> None:
    (tmp_path / "c.pem").write_text("nonsense")
    place = Place(certificate=tmp_path / "c.pem", key=tmp_path / "k.pem")
    with pytest.raises(OptionError, match="give PEM files"):
        Server(session, files=FILES, place=place).start()
