"""The grid of what was seen of the floor by everybody."""
