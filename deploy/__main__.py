"""`python -m deploy`: the `ommatidia` command, also where it is not installed."""

from deploy.cli import main

if __name__ == "__main__":
    main()
