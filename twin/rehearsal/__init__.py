"""Rehearse a test before it is done: which effects it would find, at which size, and as what."""
