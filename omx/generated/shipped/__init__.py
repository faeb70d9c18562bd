"""The modules as the book ships them: what `omx` falls back on, and what `run.py generate --restore` copies."""
