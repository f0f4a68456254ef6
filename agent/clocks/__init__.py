"""The clocks of a robot: its own, the map server's, and the map from one to the other by which everything is stamped."""
