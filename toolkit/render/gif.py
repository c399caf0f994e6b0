"""Moving pictures: drawn instants one after the other in a GIF file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from toolkit.foundation.files.replaced_file import write_whole

MOST_FRAMES, DURATION, PAUSE = 60, 4000, 1500
"""Frames at most; ms that a motion takes, and that its last frame stands still."""


def gif(frames: Sequence[Any]) -> bytes:
    """A file of frames (images of Pillow) with the colours of the last one; it is looped by whatever shows it."""
    from PIL import Image

    pace = [DURATION // len(frames)] * (len(frames) - 1) + [PAUSE]
    palette = frames[-1].quantize(255, method=Image.Quantize.MAXCOVERAGE)
    reduced = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    file = BytesIO()
    reduced[0].save(file, format="GIF", save_all=True, append_images=reduced[1:], duration=pace, loop=0, optimize=False)
    return file.getvalue()


def write_animation(
    moments: Sequence[Any],
    draw: Callable[..., None],
    look: Any,
    path: Path,
    width: int,
    progress: Callable[[int, int], None] = lambda *_: None,
) -> None:
    """Draw all moments by `draw(moment, look, path, width)` and write them as one moving picture, in one stroke."""
    from PIL import Image

    frames = []
    with TemporaryDirectory() as folder:
        for number, moment in enumerate(moments):
            drawn = Path(folder) / "frame.png"
            draw(moment, look, drawn, width)
            with Image.open(drawn) as image:
                frames.append(image.convert("RGB"))
            progress(number + 1, len(moments))
    write_whole(path, gif(frames))
