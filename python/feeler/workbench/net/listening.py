"""The server's sockets: on loopback, or on one named address with TLS if that is allowed."""

from __future__ import annotations

import errno
import socket
import ssl
from dataclasses import dataclass
from pathlib import Path

from feeler.errors import OptionError
from feeler.workbench.net.guard import Door, is_loopback, loopback_hosts

_TRIES = 10  # to find a port that is free under both addresses of loopback
_LOOPBACK = "127.0.0.1"
_HTTPS_PORT = 443


@dataclass(frozen=True)
class Place:
    """Where to listen.

    host: None: loopback. Another one needs `allow_remote` and TLS; pages must use it to address the server: a name or
    an address, not "0.0.0.0". port: 0: any free one. certificate, key: PEM files.
    """

    host: str | None = None
    port: int = 0
    allow_remote: bool = False
    certificate: Path | None = None
    key: Path | None = None

    @property
    def is_remote(self) -> bool:
        """Whether other machines can reach it."""
        return self.host is not None and not is_loopback(self.host)

    def check(self) -> None:
        """Raises `OptionError` for invalid places, and for unintended access by others."""
        if not 0 <= self.port <= 65_535:
            raise OptionError(f"port is {self.port}: give one from 0 (any that is free) to 65535")
        if (self.certificate is None) != (self.key is None):
            raise OptionError("TLS needs a certificate and its key: give both, or none")
        if not self.is_remote:
            if self.allow_remote:
                raise OptionError("remote access is allowed, but no host is given that other machines can reach")
            return
        if not self.allow_remote:
            raise OptionError(
                f"host {self.host} can be reached from other machines: allow remote access if that is meant"
            )
        if self.certificate is None:
            raise OptionError("remote access needs TLS: give a certificate and its key")
        if self.host in ("", "0.0.0.0", "::", "*"):
            raise OptionError(f"host is {self.host!r}, which is any: give the name or address that pages will call")


@dataclass(frozen=True)
class Listening:
    """Listening sockets, the accepted names of the server, and the address for a browser."""

    sockets: list[socket.socket]
    door: Door
    tls: ssl.SSLContext | None
    address: str


def listen(place: Place) -> Listening:
    """Opens the sockets. Raises `OptionError`."""
    place.check()
    tls = None if place.certificate is None else _tls(place)
    host = place.host if place.is_remote and place.host is not None else _LOOPBACK
    sockets = [_bound(host, place.port)] if place.is_remote else _loopback_sockets(place.port)
    port = int(sockets[0].getsockname()[1])
    name = f"[{host}]" if ":" in host else host
    hosts = {f"{name.lower()}:{port}"} if place.is_remote else {*loopback_hosts(port)}
    if port == _HTTPS_PORT and tls is not None:
        hosts |= {each.rpartition(":")[0] for each in hosts}  # browsers omit the default port
    door = Door(frozenset(hosts), tls is not None)
    return Listening(sockets, door, tls, f"{door.scheme}://{name}:{port}/")


def _loopback_sockets(port: int) -> list[socket.socket]:
    """127.0.0.1, and ::1 at the same port: a browser may take either for localhost."""
    for _ in range(_TRIES):
        first = _bound(_LOOPBACK, port)
        try:
            return [first, _bound("::1", int(first.getsockname()[1]))]
        except OptionError as error:
            cause = error.__cause__
            is_taken = isinstance(cause, OSError) and cause.errno == errno.EADDRINUSE
            if not is_taken or port:
                return [first]  # no IPv6 here, or that port is taken: the printed address is the other one
            first.close()
    return [_bound(_LOOPBACK, port)]


def _bound(host: str, port: int) -> socket.socket:
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        listener = socket.socket(family, kind, protocol)
    except OSError as error:
        raise OptionError(f"cannot listen on {host}: {error.strerror or error}") from error
    try:
        if family == socket.AF_INET6:
            listener.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
        listener.bind(address)
        listener.listen()
    except OSError as error:
        listener.close()
        what = f"port {port} of {host} is in use" if error.errno == errno.EADDRINUSE else str(error.strerror or error)
        raise OptionError(f"cannot listen: {what}; give another port, or 0 for any that is free") from error
    listener.setblocking(False)
    return listener


def _tls(place: Place) -> ssl.SSLContext:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    assert place.certificate is not None and place.key is not None, "checked"
    try:
        context.load_cert_chain(place.certificate, place.key)
    except (OSError, ssl.SSLError) as error:
        raise OptionError(f"TLS with {place.certificate} and {place.key}: {error}; give PEM files that fit") from None
    return context
