"""What is wrong or suspicious about a robot's description and file, and what it can do."""
