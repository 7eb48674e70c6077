"""The diagnosis: what differs between a twin and recordings, where, and what explains it."""
