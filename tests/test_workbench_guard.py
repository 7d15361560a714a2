"""Who may talk to the workbench's server: each check by itself, without a socket."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from feeler.workbench.net.guard import (
    Door,
    RateLimit,
    check_bearer,
    check_request,
    is_loopback,
    is_token,
    loopback_hosts,
    new_token,
    security_headers,
)

PORT = 51234
DOOR = Door(loopback_hosts(PORT))
HOST = f"127.0.0.1:{PORT}"


def status(*headers: tuple[str, str], method: str = "GET", host: str | None = HOST) -> int:
    """Of a refusal; 0: it may pass."""
    sent = [*headers, *((("Host", host),) if host is not None else ())]
    refused = check_request(DOOR, method, sent)
    return refused.status if refused else 0


@pytest.mark.parametrize("host", [HOST, f"localhost:{PORT}", f"[::1]:{PORT}", f"LocalHost:{PORT}"])
def test_own_names_pass(host: str) -> None:
    assert status(host=host) == 0
    assert status(("Origin", f"http://{host.lower()}"), host=host) == 0


@pytest.mark.parametrize(
    "host",
    [
        None,
        "",
        "127.0.0.1",
        "localhost",
        f"127.0.0.1:{PORT + 1}",
        f"127.0.0.1:{PORT}0",
        f"127.0.0.1:{PORT}.evil.example",
        f"127.0.0.1:{PORT}@evil.example",
        f"localhost.evil.example:{PORT}",
        f"evil.example:{PORT}",
        f"evil.localhost:{PORT}",
        f"127.0.0.1.:{PORT}",
        f" 127.0.0.1:{PORT}",
        f"127.0.0.1:{PORT} ",
        f"127.0.0.1:{PORT},evil.example",
        f"0.0.0.0:{PORT}",
        f"2130706433:{PORT}",
        f"::1:{PORT}",
        "x" * 100_000,
    ],
)
def test_other_names_are_misdirected(host: str | None) -> None:
    assert status(host=host) == 421


def test_two_hosts_are_none() -> None:
    assert status(("Host", HOST)) == 421
    assert status(("host", "evil.example")) == 421


@pytest.mark.parametrize(
    "origin",
    [
        "null",
        "",
        "http://evil.example",
        f"https://{HOST}",
        f"http://{HOST}.evil.example",
        f"http://{HOST}/",
        f"http://localhost:{PORT}",  # another origin than the Host that the request names
        "http://127.0.0.1",
        f"http://127.0.0.1:{PORT + 1}",
        f"ws://{HOST}",
        HOST,
    ],
)
def test_other_origins_are_refused(origin: str) -> None:
    assert status(("Origin", origin)) == 403


def test_two_origins_are_none() -> None:
    assert status(("Origin", f"http://{HOST}"), ("Origin", f"http://{HOST}")) == 403


@pytest.mark.parametrize(
    ("site", "expected"), [("same-origin", 0), ("none", 0), ("same-site", 403), ("cross-site", 403), ("", 403)]
)
def test_sec_fetch_site(site: str, expected: int) -> None:
    assert status(("Sec-Fetch-Site", site)) == expected


@pytest.mark.parametrize(
    "method", ["POST", "PUT", "DELETE", "OPTIONS", "HEAD", "TRACE", "CONNECT", "get", "", "G" * 9999]
)
def test_only_get(method: str) -> None:
    assert status(method=method) == 405


def test_with_tls_the_origin_is_https() -> None:
    door = Door(frozenset({"box:443"}), is_tls=True)
    assert check_request(door, "GET", [("Host", "box:443"), ("Origin", "https://box:443")]) is None
    assert check_request(door, "GET", [("Host", "box:443"), ("Origin", "http://box:443")]) is not None
    assert "wss://box:443" in security_headers(door, "box:443")["Content-Security-Policy"]


def test_tokens() -> None:
    token = new_token()
    assert len(token) >= 43 and token != new_token()
    assert is_token(token, token)
    for wrong in ("", token[:-1], token + "a", token.swapcase(), new_token(), "\ud800", "ä"):
        assert not is_token(wrong, token)


def test_bearer() -> None:
    token = new_token()
    assert check_bearer([("authorization", f"Bearer {token}")], token) is None
    bad = [
        "",
        token,
        f"bearer {token}",
        f"Bearer  {token}",
        f"Bearer {token} ",
        f"Basic {token}",
        f"Bearer {new_token()}",
    ]
    for value in bad:
        refused = check_bearer([("Authorization", value)], token)
        assert refused is not None and refused.status == 401 and token not in refused.reason
    assert check_bearer([], token) is not None
    assert check_bearer([("Authorization", f"Bearer {token}")] * 2, token) is not None
    assert check_bearer([("X-Authorization", f"Bearer {token}")], token) is not None


def test_headers_let_nothing_in_or_out() -> None:
    headers = security_headers(DOOR, HOST)
    policy = dict(each.split(" ", 1) for each in headers["Content-Security-Policy"].split("; "))
    assert policy == {
        "default-src": "'none'",
        "script-src": "'self'",
        "style-src": "'self'",
        "img-src": "'self' blob: data:",
        "connect-src": f"'self' ws://{HOST}",
        "worker-src": "'self'",
        "frame-ancestors": "'none'",
        "base-uri": "'none'",
        "form-action": "'none'",
    }
    assert headers["Cache-Control"] == "no-store" and headers["X-Content-Type-Options"] == "nosniff"
    assert headers["Referrer-Policy"] == "no-referrer"
    assert headers["Cross-Origin-Resource-Policy"] == headers["Cross-Origin-Opener-Policy"] == "same-origin"
    assert not any(name.lower().startswith("access-control") for name in headers)


def test_loopback() -> None:
    assert all(is_loopback(each) for each in ("127.0.0.1", "::1", "localhost"))
    assert not any(is_loopback(each) for each in ("", "0.0.0.0", "::", "192.168.1.2", "localhost.evil.example", "box"))


def test_a_rate_is_over_any_window() -> None:
    limit = RateLimit(3)
    assert [limit.allows(t) for t in (0.0, 0.5, 0.75, 0.875, 1.0, 1.25, 1.5, 1.75, 1.875)] == [
        *(True, True, True, False),
        *(True, False, True, True, False),
    ]


@given(st.lists(st.floats(0, 5), max_size=60), st.integers(1, 5))
def test_no_window_ever_has_more(times: list[float], most: int) -> None:
    limit = RateLimit(most)
    allowed = [t for t in sorted(times) if limit.allows(t)]
    assert all(later - earlier >= 1.0 for earlier, later in zip(allowed, allowed[most:], strict=False))


@given(
    st.lists(st.tuples(st.sampled_from(["Host", "Origin", "Sec-Fetch-Site", "Cookie"]), st.text()), max_size=5),
    st.text(),
)
def test_nothing_random_passes(headers: list[tuple[str, str]], method: str) -> None:
    refused = check_request(DOOR, method, headers)
    assert refused is not None and refused.status in (403, 405, 421)
