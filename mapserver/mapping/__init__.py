"""Pose graph, association, overlay and objects: pure functions and state on arrays, without files, clocks, threads or sockets."""
