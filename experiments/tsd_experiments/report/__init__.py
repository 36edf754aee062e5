"""Figures in the paper's layout, and the report as HTML and Markdown."""
