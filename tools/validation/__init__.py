"""Modules of tools/validate.py: rows and their scenes, renderers, closed forms, statistics, and the page."""
