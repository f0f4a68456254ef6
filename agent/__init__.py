"""The robot: from its camera's frames and its wheels' angles to a local map."""
