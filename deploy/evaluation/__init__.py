"""Scores a run against a recording's ground truth, with the tables and figures of the paper."""
