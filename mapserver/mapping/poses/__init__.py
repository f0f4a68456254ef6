"""Where the robots are: the pose graph, and what ties the paths in it together."""
