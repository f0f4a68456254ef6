"""What one local map shows, laid into the arena."""
