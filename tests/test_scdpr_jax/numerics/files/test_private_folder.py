"""What is executed is kept where its user alone can write."""

import os
import pathlib
import stat

import pytest

from scdpr_jax.numerics.files.private_folder import private_folder


def mode(folder):
    return stat.S_IMODE(folder.stat().st_mode)


def test_a_new_folder_is_closed_to_others(tmp_path):
    folder = private_folder(tmp_path / "cache" / "programs")
    assert mode(folder) == 0o700


def test_a_folder_that_others_can_read_is_closed(tmp_path):
    tmp_path.chmod(0o755)
    assert mode(private_folder(tmp_path)) == 0o700


@pytest.mark.parametrize("bits", [0o720, 0o702, 0o777])
def test_a_folder_that_others_can_write_is_refused(tmp_path, bits):
    tmp_path.chmod(bits)
    with pytest.raises(PermissionError, match="others can write there"):
        private_folder(tmp_path)
    assert mode(tmp_path) == bits


def test_a_relative_folder_is_refused():
    with pytest.raises(PermissionError, match="it is relative"):
        private_folder(pathlib.Path("cache"))


def test_another_users_folder_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "geteuid", lambda: 12345)
    with pytest.raises(PermissionError, match="another's"):
        private_folder(tmp_path)


def test_a_link_is_refused(tmp_path):
    (tmp_path / "there").mkdir()
    link = tmp_path / "link"
    link.symlink_to(tmp_path / "there")
    with pytest.raises(PermissionError, match="no folder"):
        private_folder(link)
