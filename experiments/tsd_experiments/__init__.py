"""The experiments: the paper's figures, questions beyond them, comparisons, and a demo.

``harness`` runs what they are made of, ``report`` writes what was found.
"""
