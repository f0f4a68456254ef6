"""Every figure that is promised, measured on this machine: `python -m tests.bounds`. The promises: table.py."""
