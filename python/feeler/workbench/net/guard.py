"""Access control of the server: pure functions of the request, and a rate limit on a clock that is passed in.

The server listens on loopback, where every page of every browser of this machine can reach it, by name too (DNS
rebinding). Therefore a request must name the server by a loopback address, must not come from another site, and, except
for the page's own files, must carry the token of this start.
"""

from __future__ import annotations

import hmac
import secrets
from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

TOKEN_BYTES = 32
MOST_TEXT = 200  # compared characters of a header; more is not read


@dataclass(frozen=True)
class Refused:
    """Why a request is refused. status: of HTTP; reason: for the developer of the client, without secrets."""

    status: int
    reason: str


@dataclass(frozen=True)
class Door:
    """The accepted names of the server.

    hosts: "name:port", whole strings in lower case; is_tls: whether it speaks TLS.
    """

    hosts: frozenset[str]
    is_tls: bool = False

    @property
    def scheme(self) -> str:
        """Scheme of its addresses: "http" or "https"."""
        return "https" if self.is_tls else "http"


def loopback_hosts(port: int) -> frozenset[str]:
    """Accepted Host headers of a server on this machine's own addresses."""
    return frozenset({f"127.0.0.1:{port}", f"localhost:{port}", f"[::1]:{port}"})


def is_loopback(host: str) -> bool:
    """Whether an address to listen on is this machine's own; names other than localhost are not looked up."""
    return host in ("127.0.0.1", "::1", "localhost")


def new_token() -> str:
    """A secret for one start of the server, for the fragment of its address."""
    return secrets.token_urlsafe(TOKEN_BYTES)


def is_token(given: str, token: str) -> bool:
    """Whether a token is right, in constant time."""
    return hmac.compare_digest(given.encode("utf-8", "surrogatepass"), token.encode())


def check_request(door: Door, method: str, headers: Iterable[tuple[str, str]]) -> Refused | None:
    """Checks every request, also for a socket: method, Host, Origin, Sec-Fetch-Site. None: accepted.

    An empty Origin counts as present, and is wrong; each of these headers may occur at most once.
    """
    found: dict[str, list[str]] = {}
    for name, value in headers:
        found.setdefault(name.lower(), []).append(value)
    if method != "GET":
        return Refused(405, f"method {method[:20]}: only GET is answered")
    host = _single(found, "host")
    # The whole string is compared, because bytes may follow a port, or a name with the right beginning.
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
    """Headers of every answer. host: the name in the request, one of the door's."""
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
        "Cache-Control": "no-store",  # a mock-up is secret, and a disk cache is not
    }


class RateLimit:
    """Allows a limited number in any time window."""

    def __init__(self, most: int, window_s: float = 1.0) -> None:
        self._most = most
        self._window_s = window_s
        self._times: deque[float] = deque(maxlen=most)

    def allows(self, now_s: float) -> bool:
        """Whether one more is allowed now; counts it if so. now_s: of a clock that never goes back."""
        if len(self._times) == self._most and now_s - self._times[0] < self._window_s:
            return False
        self._times.append(now_s)
        return True
