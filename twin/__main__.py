"""The command ``twin``, and ``python -m twin``."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command line; an interruption while the program is still loading is one line, too."""
    try:
        from twin.cli import main as run

        run()
    except KeyboardInterrupt:
        sys.stderr.write("twin: interrupted\n")
        sys.exit(130)


if __name__ == "__main__":
    main()
