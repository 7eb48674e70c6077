"""The machine a benchmark ran on, in words that identify nobody's."""

from __future__ import annotations

import os
import platform
from pathlib import Path


def described() -> str:
    """Return cores, processor, memory and Python version."""
    fields = {}
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        for line in cpuinfo.read_text().splitlines():
            key, _, value = line.partition(":")
            fields.setdefault(key.strip(), value.strip())
    model = fields.get("model name", platform.machine())
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    return (
        f"{os.cpu_count()} cores {model}, {memory:.0f} GiB, {platform.system()}, "
        f"Python {platform.python_version()}, one BLAS thread"
    )
