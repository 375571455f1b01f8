"""python -m chiasm.export is the command `chiasm`."""

from .cli import main

main(prog_name="chiasm")
