"""How the robot moves: setpoints, tracking law, limits and the local guard, as pure functions and small states."""
