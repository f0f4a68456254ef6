"""Where the robot is and what stands around it: pure functions and small filters."""
