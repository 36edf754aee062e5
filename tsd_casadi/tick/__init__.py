"""What goes into a control tick and comes out of it: layouts, command, status, reply."""
