"""The commands of 'tsd', one module each."""
