"""Calibration with somebody at the terminal: files in, progress and verdict on the screen, calibration files out."""
