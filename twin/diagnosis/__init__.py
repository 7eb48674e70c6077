"""From a recording that the twin does not reproduce to the twin that does."""
