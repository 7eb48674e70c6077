"""The paper's ledger: every printed number beside ours, and what contradicts what.

Run: python experiments/paper_ledger.py [FOLDER]
Prints the table; with a folder, also writes ledger.txt and ledger.json there.
"""

import sys

from twin.cli import main

if __name__ == "__main__":
    main(["paper", *(["--out", sys.argv[1]] if len(sys.argv) > 1 else [])])
