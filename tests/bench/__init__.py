"""How long the agent takes for a frame, how many bytes a frame costs, and what the same would cost otherwise: `python -m tests.bench`."""
