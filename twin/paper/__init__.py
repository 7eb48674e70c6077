"""The paper's numbers, recomputed: what agrees, what contradicts what, and why.

The paper is C. M. Pappalardo and D. Guida, "System Identification and Experimental Modal
Analysis of a Frame Structure". Numbers in parentheses are its equations.
"""

from twin.paper.contradictions import Contradiction, contradictions
from twin.paper.ledger import Entry, ledger

__all__ = ["Contradiction", "Entry", "contradictions", "ledger"]
