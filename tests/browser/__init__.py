"""What a reader does, in a real JupyterLab and a real browser."""
