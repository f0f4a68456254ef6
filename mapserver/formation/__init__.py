"""Where every robot should be: shapes, paths on the mapped floor, narrow places, exploration. Pure and deterministic."""
