"""How robots whose start nobody knows find their places: candidates, certainty, and when one may join."""
