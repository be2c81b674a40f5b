"""What a call that fails says, and a file that is spoilt."""

from experiments.cli import main


def told(capsys, *call, status=2):
    """The one message of a call that fails."""
    assert main([*map(str, call)]) == status
    return " ".join(capsys.readouterr().err.split())


def spoil(file, old, new):
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))
