"""Renders the images of docs/gallery.md."""
