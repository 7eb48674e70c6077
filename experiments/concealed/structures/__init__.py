"""Concealed cases on structures beyond the chain: a portal in space, a beam, a drive.

Matrices are assembled by hand here and integrated by a method of their own (``stepping.py``); from
``twin`` only the error family and the writing of files are used.
"""
