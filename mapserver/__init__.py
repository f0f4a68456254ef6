"""The eye: merges the robots' local maps into one global map and holds every robot's pose in the arena."""
