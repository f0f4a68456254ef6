"""The simulated world as pure functions: what there is, how a camera sees it, how bodies move in it."""
