"""What every test needs: one thread for small matrices, and the folders beside the package."""

import os
import sys
from pathlib import Path

# Two workers share two cores: linear algebra on small matrices gains nothing from threads.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# `experiments` is not part of the installed package. Appended, so that the installed one is tested.
sys.path.append(str(Path(__file__).resolve().parents[1]))
