"""Logs of repetitions as files, tick by tick."""
