"""Two workers share two cores: linear algebra on small matrices gains nothing from threads."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
