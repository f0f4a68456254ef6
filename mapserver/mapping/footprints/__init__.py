"""The footprints of upright things, from what several views show of them. Pure functions."""
