"""Output files: asked for before the work starts, and never seen half-written."""

from __future__ import annotations

import os
import re
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

_UNFINISHED = re.compile(r"\.(frame_)?\d{4,}-\w{8}\.\w+")


class CaptureError(RuntimeError):
    """A file that cannot be written or read; the message says which, why and what to do."""


def require_writable(path: Path | str, *, make_folder: bool = False) -> Path:
    """The path, once it is certain that a file can be made there: the folder exists and takes a new file.

    With ``make_folder`` the path is a folder that is made when missing. Raises CaptureError; call it before rendering.
    """
    path = Path(path)
    folder = path if make_folder else path.parent
    if make_folder:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            reason = error.strerror
            raise CaptureError(f"the output folder {folder} cannot be made ({reason}); name another one") from error
    if not folder.exists():
        raise CaptureError(f"the output folder {folder} does not exist; make it first or name another one")
    if not folder.is_dir():
        raise CaptureError(f"{folder} is a file, so nothing can be written into it; name a folder")
    if not make_folder and path.is_dir():
        raise CaptureError(f"{path} is a folder; give the name of a file to write in it")
    try:
        # os.access lies on network drives and for root: make a file, as the real one will be made.
        with tempfile.NamedTemporaryFile(dir=folder, prefix=".planetfall-"):
            pass
    except OSError as error:
        raise CaptureError(
            f"the output folder {folder} cannot be written to ({error.strerror}); name another one or change its rights"
        ) from error
    return path


@contextmanager
def written_beside(path: Path | str) -> Iterator[Path]:
    """Yields a name in the same folder to write to; on success it is renamed to ``path``, on failure it is removed.

    The name keeps the suffix, because many writers choose their format by it. CaptureError when the disk is full, the
    folder is gone, or the system says anything else against it.
    """
    path = Path(path)
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}-", suffix=path.suffix)
    except OSError as error:
        raise _not_written(path, error) from error
    os.close(handle)
    beside = Path(name)
    try:
        yield beside
        umask = os.umask(0)
        os.umask(umask)
        beside.chmod(0o666 & ~umask)  # mkstemp makes files for the owner only
        beside.replace(path)
    except OSError as error:
        if error.errno is None:  # not the system's, but a writer's own, such as OutputError
            raise
        raise _not_written(path, error) from error
    finally:
        beside.unlink(missing_ok=True)


def _not_written(path: Path, error: OSError) -> CaptureError:
    why = error.strerror or error
    return CaptureError(f"{path} cannot be written ({why}); make room, change its rights or name another one")


def remove_unfinished(folder: Path) -> None:
    """Remove what writers that were killed have left beside numbered files, such as .000012-x1y2z3.png.

    Files younger than a minute may belong to somebody who is writing them.
    """
    for left in folder.iterdir():
        if _UNFINISHED.fullmatch(left.name):
            with suppress(OSError):
                if time.time() - left.stat().st_mtime > 60.0:
                    left.unlink()
