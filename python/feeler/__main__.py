"""The program `feeler`, also as `python -m feeler`."""

import os
import signal
import sys


def main() -> None:
    """Runs the program. Ctrl-C while its modules are imported ends it, as later, in one line."""
    is_heard = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if is_heard:
        signal.signal(signal.SIGINT, _end)
    from feeler.cli import main as run

    if is_heard:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    run()


def _end(*_: object) -> None:
    if sys.stderr is not None:
        os.write(2, b"feeler: interrupted\n")
    os._exit(130)


if __name__ == "__main__":
    main()
