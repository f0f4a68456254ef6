"""What stands in the arena, and what moves there."""
