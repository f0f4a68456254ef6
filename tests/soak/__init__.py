"""Long runs: the swarm in many random arenas. `python -m tests.soak`."""
