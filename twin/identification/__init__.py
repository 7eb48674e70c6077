"""Identification of linear models from recordings: OKID, ERA and what refines them."""
