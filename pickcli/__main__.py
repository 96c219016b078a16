"""``python -m pickcli`` is ``apc``."""

from pickcli.commands.main import main

main()
