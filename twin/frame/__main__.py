"""``python -m twin.frame [FOLDER]`` writes the models that come with the package."""

from __future__ import annotations

import sys
from pathlib import Path

from twin.frame import write_models

for path in write_models(Path(sys.argv[1] if len(sys.argv) > 1 else "models")):
    print(path)
