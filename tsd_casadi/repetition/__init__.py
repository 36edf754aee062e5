"""One execution of a motion on a plant, and learning from one to the next.

What measures, watches and adds to commands or torques in the loop is here too.
"""
