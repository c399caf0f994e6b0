"""Fixtures of the tests of preprocessing."""

from __future__ import annotations

import subprocess

import pytest
from typer.testing import CliRunner

from preprocessing.projects import command


@pytest.fixture
def in_this_process(monkeypatch):
    """The program behind `ffrf new` runs here, which saves its imports."""

    def run(name, arguments):
        assert name == command.__name__
        done = CliRunner().invoke(command.app, arguments)
        assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
        return subprocess.CompletedProcess(arguments, done.exit_code, done.stdout, done.stderr)

    monkeypatch.setattr("toolkit.command_line.commands.new_project.run", run)
