"""The command ``twin``, and ``python -m twin``."""

from __future__ import annotations

import _thread
import os
import signal
import sys
import time
from typing import NoReturn


def main() -> None:
    """Run the command line; an interruption while the program is still loading is one line, too.

    Where it falls into a compiled module that is being loaded, another error comes out of it; where
    it falls into a destructor, none: it is raised again.
    """
    asked = False

    def interrupt(*_: object) -> NoReturn:
        nonlocal asked
        asked = True
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, interrupt)
    sys.unraisablehook = raised_nowhere
    try:
        from twin.cli import main as run

        run()
    except KeyboardInterrupt:
        _interrupted()
    except Exception:
        if not asked:
            raise
        _interrupted()


def raised_nowhere(unraisable: sys.UnraisableHookArgs) -> None:
    """Raise an interruption again that a destructor or a callback has swallowed."""
    if unraisable.exc_type is not None and issubclass(unraisable.exc_type, KeyboardInterrupt):
        # not from here: what is raised inside this hook is swallowed as well
        _thread.start_new_thread(_again, ())
    else:
        sys.__unraisablehook__(unraisable)


def _again() -> None:
    time.sleep(0.02)
    os.kill(os.getpid(), signal.SIGINT)


def _interrupted() -> NoReturn:
    sys.stderr.write("twin: interrupted\n")
    sys.exit(130)


if __name__ == "__main__":
    main()
