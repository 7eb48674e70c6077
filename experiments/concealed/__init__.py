"""Concealed cases: recordings of rigs in which one effect is hidden, and the sealed truth apart.

The motion comes from an integrator of its own (``integrator.py``, numba), so that a tool built on
MuJoCo is not tested on its own equations. From ``twin`` only recordings, their files and the error
family are used; the campaign also uses ``twin.campaign`` and, lazily, the command's diagnosis.
"""
