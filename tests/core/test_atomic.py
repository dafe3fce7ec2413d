"""Writing over a file: whose it is, who may read it, and what is no file."""

import os
import stat
from pathlib import Path

import pytest

from paint3d.cli import main
from paint3d.core.atomic import write_atomically
from paint3d.errors import ExportError

ACCESS_LIST = "system.posix_acl_access"
IS_ROOT = hasattr(os, "geteuid") and os.geteuid() == 0
needs_root = pytest.mark.skipif(not IS_ROOT, reason="only the superuser may give files away")


def mode_of(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


def written_over(path: Path) -> Path:
    with write_atomically(path) as part:
        part.write_text("new")
    assert path.read_text() == "new"
    return path


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o664, 0o444, 0o755])
@pytest.mark.parametrize("is_link", [False, True])
def test_a_file_that_is_written_over_keeps_its_permissions(tmp_path, mode, is_link):
    path = tmp_path / "a.txt"
    path.write_text("old")
    path.chmod(mode)
    named = path
    if is_link:
        named = tmp_path / "link.txt"
        named.symlink_to(path)
    written_over(named)
    assert mode_of(path) == mode
    assert named.is_symlink() == is_link


def test_a_command_keeps_the_permissions_of_what_it_replaces(tmp_path):
    out = tmp_path / "a.obj"
    out.write_text("old")
    out.chmod(0o600)
    assert main.main(["export", "plane", str(out), "--quiet"]) == 0
    assert out.read_text() != "old"
    assert mode_of(out) == 0o600


@pytest.mark.parametrize("mask", [0o022, 0o027, 0o077])
def test_a_new_file_has_what_the_mask_leaves(tmp_path, mask):
    before = os.umask(mask)
    try:
        assert mode_of(written_over(tmp_path / "a.txt")) == 0o666 & ~mask
    finally:
        os.umask(before)


def test_nobody_else_sees_a_private_file_while_it_is_written(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    path.chmod(0o600)
    with write_atomically(path) as part:
        assert mode_of(part) == 0o600
        part.write_text("new")


@needs_root
def test_owner_and_group_stay_where_that_is_allowed(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    os.chown(path, 12345, 23456)
    path.chmod(0o640)
    found = written_over(path).stat()
    assert (found.st_uid, found.st_gid, mode_of(path)) == (12345, 23456, 0o640)


@pytest.mark.parametrize(("mode", "expected"), [(0o660, 0o600), (0o664, 0o644), (0o604, 0o604)])
@needs_root
def test_another_group_does_not_gain_access(tmp_path, monkeypatch, mode, expected):
    path = tmp_path / "a.txt"
    path.write_text("old")
    os.chown(path, -1, 23456)
    path.chmod(mode)

    def refuse(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "chown", refuse)
    assert mode_of(written_over(path)) == expected


def access_list(*entries: tuple[int, int, int]) -> bytes:
    """What Linux stores: tag, permissions, number of the user or group."""
    packed = b"".join(
        tag.to_bytes(2, "little") + may.to_bytes(2, "little") + who.to_bytes(4, "little")
        for tag, may, who in entries
    )
    return (2).to_bytes(4, "little") + packed


def with_access_list(path: Path) -> bytes:
    """A file that its owner and one more user may write, and its group may not even read."""
    nobody = 0xFFFFFFFF
    told = access_list(
        (1, 6, nobody), (2, 6, 4242), (4, 0, nobody), (16, 6, nobody), (32, 0, nobody)
    )
    path.write_text("old")
    try:
        os.setxattr(path, ACCESS_LIST, told)
    except (AttributeError, OSError):
        pytest.skip("files have no access lists here")
    assert mode_of(path) == 0o660  # of which the middle is what the list may give at most
    return told


def test_an_access_list_is_kept(tmp_path):
    told = with_access_list(tmp_path / "a.txt")
    assert os.getxattr(written_over(tmp_path / "a.txt"), ACCESS_LIST) == told
    assert mode_of(tmp_path / "a.txt") == 0o660


def test_without_its_access_list_a_file_is_not_opened_to_its_group(tmp_path, monkeypatch):
    with_access_list(tmp_path / "a.txt")

    def refuse(*_: object) -> None:
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(os, "setxattr", refuse)
    assert mode_of(written_over(tmp_path / "a.txt")) == 0o600


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes here")
def test_a_pipe_is_not_replaced(tmp_path, capsys):
    pipe, link = tmp_path / "pipe.obj", tmp_path / "link.obj"
    os.mkfifo(pipe)
    link.symlink_to(pipe)
    for name in (pipe, link):
        with pytest.raises(ExportError, match="a pipe or a device"), write_atomically(name):
            pytest.fail("it was written")
        assert main.main(["export", "plane", str(name), "--quiet"]) == 2
        assert "is a pipe or a device; expected a file name" in capsys.readouterr().err
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert sorted(os.listdir(tmp_path)) == ["link.obj", "pipe.obj"]


@needs_root
def test_a_device_is_not_replaced(tmp_path):
    device = tmp_path / "null.txt"
    try:
        os.mknod(device, stat.S_IFCHR | 0o666, os.makedev(1, 3))
    except OSError:
        pytest.skip("devices cannot be made here")
    with pytest.raises(ExportError, match="a pipe or a device"), write_atomically(device):
        pytest.fail("it was written")
    assert stat.S_ISCHR(device.stat().st_mode)
