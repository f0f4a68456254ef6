"""What the agent makes of recorded frames, kept in files: a change of the pipeline's output shows there, and is made on purpose.

`python -m tests.golden` writes the files anew. That belongs in a commit of its own, which shows the evaluation before and after.
"""
