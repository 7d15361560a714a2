"""`python -m feeler` is the command `feeler`."""

from feeler.cli import main

if __name__ == "__main__":
    main()
