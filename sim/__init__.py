"""The world outside the robots: it stands where the metal stands, and reaches them over the bus alone."""
