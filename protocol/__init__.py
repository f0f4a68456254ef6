"""The vocabulary that all rooms share: messages, topics, codec, planar poses, errors, and the bus."""
