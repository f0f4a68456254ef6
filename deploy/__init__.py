"""How ommatidia is started and judged: the command line, the launcher, the recorder and the evaluation."""
