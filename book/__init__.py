"""The book around the notebooks: its site, and the tools that run, check and publish the chapters."""
