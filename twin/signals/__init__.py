"""Filters and band-limited resampling, used by the laboratory and by the analysis alike."""

from twin.signals.low_pass import LowPass, anti_alias, decimate
from twin.signals.resampling import resample

__all__ = ["LowPass", "anti_alias", "decimate", "resample"]
