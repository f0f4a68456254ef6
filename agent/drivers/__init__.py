"""The robot's metal behind small protocols: one file a driver."""
