"""What the page shows, one class a panel."""
