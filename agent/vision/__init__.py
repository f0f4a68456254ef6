"""Vision: pure functions on arrays, each step of the method in a file of its own."""
