"""Pictures, arrays, sheets and videos on disk."""

from __future__ import annotations

import errno
import os
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from planetfall.systems.capture import (
    CaptureError,
    NumberedFrames,
    VideoError,
    contact_sheet,
    read_arrays,
    read_png_settings,
    require_writable,
    write_arrays,
    write_png,
    write_video,
    written_beside,
)
from planetfall.systems.capture.sheet import even_selection


def pixels(width: int = 32, height: int = 18, value: int = 90) -> np.ndarray:
    picture = np.full((height, width, 3), value, np.uint8)
    picture[0, 0] = (255, 0, 0)
    return picture


def test_png_carries_its_settings(tmp_path: Path) -> None:
    settings = {
        "planet": "earth",
        "camera": {"position_m": np.array([1.5, 2.0, 3.0])},
        "größe": [32, 18],
        "ev": np.float32(2),
    }
    path = write_png(tmp_path / "a.png", pixels(), settings)
    back = read_png_settings(path)
    assert back == {"planet": "earth", "camera": {"position_m": [1.5, 2.0, 3.0]}, "größe": [32, 18], "ev": 2.0}
    assert tuple(np.asarray(Image.open(path))[0, 0]) == (255, 0, 0)
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]


def test_png_without_settings_says_so(tmp_path: Path) -> None:
    Image.new("RGB", (2, 2)).save(tmp_path / "b.png")
    with pytest.raises(CaptureError, match=r"b\.png carries no Planetfall settings"):
        read_png_settings(tmp_path / "b.png")
    (tmp_path / "c.png").write_text("no picture")
    with pytest.raises(CaptureError, match="cannot be read as a picture"):
        read_png_settings(tmp_path / "c.png")


def test_png_refuses_floats(tmp_path: Path) -> None:
    with pytest.raises(CaptureError, match=r"u8 pixels, found float32; use \.npz"):
        write_png(tmp_path / "a.png", np.zeros((2, 2, 3), np.float32))  # pyright: ignore[reportArgumentType]


def test_arrays_round_trip(tmp_path: Path) -> None:
    outputs = {"distance": np.full((3, 4), np.inf, np.float32), "surface": np.ones((3, 4), np.uint8)}
    path = write_arrays(
        tmp_path / "a.npz", outputs, camera={"position_m": (1, 2, 3e7)}, exposure=0.25, settings={"view": "near"}
    )
    arrays, settings = read_arrays(path)
    assert settings == {"view": "near"}
    assert arrays["distance"].dtype == np.float32 and np.isinf(arrays["distance"]).all()
    assert arrays["camera_position_m"].dtype == np.float64 and arrays["camera_position_m"][2] == 3e7
    assert float(arrays["exposure"]) == 0.25
    np.savez(tmp_path / "b.npz", x=np.zeros(1))
    with pytest.raises(CaptureError, match="carries no Planetfall settings"):
        read_arrays(tmp_path / "b.npz")


def test_a_failed_write_leaves_the_old_file(tmp_path: Path) -> None:
    target = tmp_path / "x.txt"
    target.write_text("old")
    with pytest.raises(RuntimeError), written_beside(target) as beside:
        beside.write_text("half")
        raise RuntimeError
    assert target.read_text() == "old" and len(list(tmp_path.iterdir())) == 1


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX rights")
def test_what_the_system_says_against_a_file_is_told(tmp_path: Path) -> None:
    with (
        pytest.raises(CaptureError, match=r"a\.txt cannot be written \(No space left"),
        written_beside(tmp_path / "a.txt"),
    ):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    with pytest.raises(CaptureError, match="No such file"), written_beside(tmp_path / "gone" / "a.txt"):
        pass
    (tmp_path / "folder").mkdir()
    with pytest.raises(CaptureError, match="folder cannot be written"), written_beside(tmp_path / "folder"):
        pass
    with pytest.raises(OSError, match="a writer's own"), written_beside(tmp_path / "a.txt"):
        raise OSError("a writer's own")
    assert [path.name for path in tmp_path.iterdir()] == ["folder"]


def test_what_killed_writers_left_is_removed_once_it_is_old(tmp_path: Path) -> None:
    own = ["000012.png", ".hidden-12345678.png", "frame_0001.png", ".0001.png"]
    for name in (*own, ".000012-ab_d3f5h.npz", ".frame_0001-ab_d3f5h.png", ".000013-ab_d3f5h.json"):
        (tmp_path / name).touch()
        if "000013" not in name:
            os.utime(tmp_path / name, (0, 0))
    NumberedFrames(tmp_path, 2, force=True)
    left = {path.name for path in tmp_path.iterdir()}
    assert left == {*own, "sequence.json", ".000013-ab_d3f5h.json"} - {"frame_0001.png"}
    with written_beside(tmp_path / "000012.png") as beside:  # its names are of that kind
        os.utime(beside, (0, 0))
        NumberedFrames(tmp_path, 2, force=True)
        assert not beside.exists()
        beside.touch()


def test_written_files_get_the_usual_rights(tmp_path: Path) -> None:
    (tmp_path / "plain").write_text("")
    write_png(tmp_path / "a.png", pixels())
    assert (tmp_path / "a.png").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_output_folder_is_checked_before_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(CaptureError, match=r"folder .*nowhere does not exist; make it first"):
        require_writable(tmp_path / "nowhere" / "a.png")
    (tmp_path / "file").write_text("")
    with pytest.raises(CaptureError, match="is a file"):
        require_writable(tmp_path / "file" / "a.png")
    with pytest.raises(CaptureError, match="is a folder; give the name of a file"):
        require_writable(tmp_path)
    with pytest.raises(CaptureError, match="cannot be made"):
        require_writable(tmp_path / "file" / "deeper", make_folder=True)
    assert require_writable(tmp_path / "new" / "deep", make_folder=True).is_dir()

    def refuse(*args: object, **kwargs: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("tempfile.NamedTemporaryFile", refuse)
    with pytest.raises(CaptureError, match=r"cannot be written to \(Permission denied\)"):
        require_writable(tmp_path / "a.png")


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write anywhere")
def test_read_only_folder(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(CaptureError, match="cannot be written to"):
            require_writable(tmp_path / "a.png")
    finally:
        tmp_path.chmod(0o700)


def test_contact_sheet_holds_every_picture(tmp_path: Path) -> None:
    write_png(tmp_path / "a.png", pixels(64, 36, 200))
    page = contact_sheet(
        [("a", tmp_path / "a.png"), ("b", pixels(64, 36, 120)), ("c", pixels(32, 18, 60))], columns=2, thumb_width=64
    )
    assert page.dtype == np.uint8 and page.shape[1] == 2 * 70 + 6
    counts = [int(np.sum(np.all(page == value, axis=2))) for value in (200, 120, 60)]
    assert all(count > 0.9 * 64 * 36 for count in counts)
    with pytest.raises(CaptureError, match="at least one picture"):
        contact_sheet([])
    assert even_selection(range(100), 3) == [0, 50, 99]


def test_numbered_frames_resume(tmp_path: Path) -> None:
    frames = NumberedFrames(tmp_path / "out", 3, settings={"size": [32, 18]})
    frames.write(1, pixels())
    again = NumberedFrames(tmp_path / "out", 3, settings={"size": [32, 18]})
    assert list(again.missing()) == [0, 2]
    assert again.paths[0].name == "frame_0000.png"
    cut = again.write(2, pixels())
    assert list(again.missing()) == [0]
    cut.write_bytes(cut.read_bytes()[:-5])
    (tmp_path / "out" / "frame_0000.png").write_bytes(b"")
    assert list(again.missing()) == [0, 2], "half a file is no frame"
    cut.unlink()
    with pytest.raises(CaptureError, match="made with other settings; replace them by force \\(--force\\)"):
        NumberedFrames(tmp_path / "out", 3, settings={"size": [64, 36]})
    forced = NumberedFrames(tmp_path / "out", 3, settings={"size": [64, 36]}, force=True)
    assert list(forced.missing()) == [0, 1, 2]
    with pytest.raises(CaptureError, match="count = 0"):
        NumberedFrames(tmp_path / "out", 0)
    (tmp_path / "other").mkdir()
    write_png(tmp_path / "other" / "frame_0000.png", pixels())
    with pytest.raises(CaptureError, match="unknown origin"):
        NumberedFrames(tmp_path / "other", 2)


def test_video(tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg")
    write_png(tmp_path / "a.png", pixels(65, 37))
    path = write_video(tmp_path / "a.mp4", [tmp_path / "a.png", pixels(65, 37), pixels(65, 37, 10)], fps=12)
    assert path.stat().st_size > 500 and path.read_bytes()[4:8] == b"ftyp"
    with pytest.raises(VideoError, match="frame 1 is 32x18, expected 64x36"):
        write_video(tmp_path / "b.mp4", [pixels(64, 36), pixels(32, 18)])
    with pytest.raises(VideoError, match="at least one frame"):
        write_video(tmp_path / "b.mp4", [])
    with pytest.raises(VideoError, match=r"ends in \.mp4"):
        write_video(tmp_path / "b.gif", [pixels()])
    assert not (tmp_path / "b.mp4").exists()


def test_no_video_of_a_single_row(tmp_path: Path) -> None:
    """Cut to even sizes nothing is left of it: an error, and no empty file."""
    with pytest.raises(VideoError, match="16x1 make no video"):
        write_video(tmp_path / "flight.mp4", [np.zeros((1, 16, 3), np.uint8)])
    assert not list(tmp_path.iterdir())


def test_video_without_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(VideoError, match=r"pip install 'planetfall\[video\]'"):
        write_video(tmp_path / "a.mp4", [pixels()])
