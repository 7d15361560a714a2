"""Who may talk to the server, and how much: pure functions of what a request says, and a limit on a clock passed in.

The server listens on loopback, where every page of every browser of this machine can reach it, by name too (DNS
rebinding). So a request has to name the server by an address of loopback, must not come from another site, and, for
all but the page's own files, has to carry the token of this start.
"""

from __future__ import annotations

import hmac
import secrets
from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

TOKEN_BYTES = 32
MOST_TEXT = 200  # of a header that is compared; more is not read


@dataclass(frozen=True)
class Refused:
    """Why a request is not answered. status: of HTTP; reason: for whoever wrote the client, without secrets."""

    status: int
    reason: str


@dataclass(frozen=True)
class Door:
    """By which names the server may be called.

    hosts: "name:port", whole strings in lower case; is_tls: whether it speaks TLS.
    """

    hosts: frozenset[str]
    is_tls: bool = False

    @property
    def scheme(self) -> str:
        """Of its addresses: "http" or "https"."""
        return "https" if self.is_tls else "http"


def loopback_hosts(port: int) -> frozenset[str]:
    """What a Host header may be of a server on this machine's own addresses."""
    return frozenset({f"127.0.0.1:{port}", f"localhost:{port}", f"[::1]:{port}"})


def is_loopback(host: str) -> bool:
    """Whether an address to listen on is this machine's own; a name other than localhost is not looked up."""
    return host in ("127.0.0.1", "::1", "localhost")


def new_token() -> str:
    """A secret of one start of the server, for the fragment of its address."""
    return secrets.token_urlsafe(TOKEN_BYTES)


def is_token(given: str, token: str) -> bool:
    """Whether a token is the right one; takes as long wherever they differ."""
    return hmac.compare_digest(given.encode("utf-8", "surrogatepass"), token.encode())


def check_request(door: Door, method: str, headers: Iterable[tuple[str, str]]) -> Refused | None:
    """What every request is asked, that for a socket too: method, Host, Origin, Sec-Fetch-Site. None: it may pass.

    An empty Origin is one that is sent, and wrong; each of these headers may be there once at most.
    """
    found: dict[str, list[str]] = {}
    for name, value in headers:
        found.setdefault(name.lower(), []).append(value)
    if method != "GET":
        return Refused(405, f"method {method[:20]}: only GET is answered")
    host = _single(found, "host")
    # Bytes after a port or a name that only begins right must not pass: the whole string is compared.
    if host is None or host.lower() not in door.hosts:
        return Refused(421, "this server is not called so: use the address that it printed")
    if "origin" in found and _single(found, "origin") != f"{door.scheme}://{host.lower()}":
        return Refused(403, "the request comes from another site")
    if "sec-fetch-site" in found and _single(found, "sec-fetch-site") not in ("same-origin", "none"):
        return Refused(403, "the request comes from another site")
    return None


def check_bearer(headers: Iterable[tuple[str, str]], token: str) -> Refused | None:
    """Whether a request has `Authorization: Bearer TOKEN`. None: it has."""
    given = [value for name, value in headers if name.lower() == "authorization"]
    if len(given) != 1 or not given[0].startswith("Bearer ") or not is_token(given[0][len("Bearer ") :], token):
        return Refused(401, "without the token of this start: open the address that the server printed")
    return None


def _single(found: Mapping[str, list[str]], name: str) -> str | None:
    values = found.get(name, [])
    return values[0] if len(values) == 1 and len(values[0]) <= MOST_TEXT else None


def security_headers(door: Door, host: str) -> dict[str, str]:
    """What every answer carries. host: by which the page called, one of the door's."""
    socket = f"{'wss' if door.is_tls else 'ws'}://{host}"
    policy = {
        "default-src": "'none'",
        "script-src": "'self'",
        "style-src": "'self'",
        "img-src": "'self' blob: data:",
        "connect-src": f"'self' {socket}",
        "worker-src": "'self'",
        "frame-ancestors": "'none'",
        "base-uri": "'none'",
        "form-action": "'none'",
    }
    return {
        "Content-Security-Policy": "; ".join(f"{name} {value}" for name, value in policy.items()),
        "X-Content-Type-Options": "nosniff",
        "Referrer-Policy": "no-referrer",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Cross-Origin-Opener-Policy": "same-origin",
        "Cache-Control": "no-store",  # a mock-up is a secret, and a disk cache is not
    }


class RateLimit:
    """At most so many in any window of time."""

    def __init__(self, most: int, window_s: float = 1.0) -> None:
        self._most = most
        self._window_s = window_s
        self._times: deque[float] = deque(maxlen=most)

    def allows(self, now_s: float) -> bool:
        """Whether one more may come now; it counts if so. now_s: of a clock that never goes back."""
        if len(self._times) == self._most and now_s - self._times[0] < self._window_s:
            return False
        self._times.append(now_s)
        return True
