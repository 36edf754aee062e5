"""The paper's outlook: generalisation over more than one parameter, from tens of entries."""
