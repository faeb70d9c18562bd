"""Tests: one file per module; tests/browser drives a real JupyterLab."""
