"""What is wrong with a robot, part by part: one file a part, and the order in diagnosis.py."""
