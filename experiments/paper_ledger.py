"""The paper's ledger: every printed number beside ours, and what contradicts what.

Run: python experiments/paper_ledger.py
The command ``twin paper`` prints the same and writes it as JSON on request.
"""

from rich.console import Console

from twin.cli.paper import show
from twin.paper import contradictions, ledger

if __name__ == "__main__":
    show(Console(highlight=False), ledger(), contradictions())
