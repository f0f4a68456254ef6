"""How the robot drives: the helm answers setpoints, the wheel guard alone owns the wheels; pipes join the processes."""
