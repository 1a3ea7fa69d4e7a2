"""Modules of compare_renderers.py."""
