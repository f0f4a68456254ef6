"""A robot without a camera: it knows its speeds, and range and bearing of what it sees and can name."""
