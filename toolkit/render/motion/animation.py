"""Moving pictures: drawn instants one after the other in a GIF file or an MP4 file."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Sequence
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from toolkit.foundation.spread import spread
from toolkit.render.motion.names import NamesOfMotion
from toolkit.render.packages import RenderError

MOST_FRAMES, DURATION, PAUSE = 60, 4000, 1500
"""Frames at most; ms that a motion takes, and that its last frame stands still."""
LOOKED_AT = 9
"""Frames that are looked at before names get their places and pictures their colours."""


def mp4(frames: Sequence[Any]) -> bytes:
    """Content of a film (H.264) of frames in all colours; an odd row or column of pixels, which it cannot have, is left out.

    Raises
    ------
    RenderError
        ffmpeg, which runs in a process of its own, fails; with what it says.
    """
    from imageio_ffmpeg import get_ffmpeg_exe

    width, height = (size - size % 2 for size in frames[0].size)
    rate = max(1, round(1000 * len(frames) / DURATION))
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", str(rate), "-i", "-"]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "film.mp4"
        command = [
            get_ffmpeg_exe(),
            "-loglevel",
            "error",
            *raw,
            "-c:v",
            "libx264",
            "-crf",
            "18",
            "-pix_fmt",
            "yuv420p",
            str(path),
        ]
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
            assert process.stdin is not None
            with suppress(BrokenPipeError):  # ffmpeg has ended, and says why
                for frame in [*frames, *[frames[-1]] * -(-rate * PAUSE // 1000)]:
                    process.stdin.write(frame.crop((0, 0, width, height)).tobytes())
            _, said = process.communicate()
        if process.returncode:
            raise RenderError(
                f"ffmpeg has made no film: {said.decode(errors='replace').strip()}. Take --animate, which makes a GIF."
            )
        return path.read_bytes()


def gif(frames: Sequence[Any]) -> bytes:
    """Content of a GIF of frames (images of Pillow) with the colours of some of them; whatever shows it loops it."""
    from PIL import Image

    pace = [DURATION // len(frames)] * (len(frames) - 1) + [PAUSE]
    few, (width, height) = spread(len(frames) - 1, LOOKED_AT), frames[0].size
    together = Image.new("RGB", (width, height * len(few)))
    for row, k in enumerate(few):
        together.paste(frames[k], (0, height * row))
    palette = together.quantize(255, method=Image.Quantize.FASTOCTREE)
    reduced = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    file = BytesIO()
    reduced[0].save(file, format="GIF", save_all=True, append_images=reduced[1:], duration=pace, loop=0, optimize=False)
    return file.getvalue()


def drawn_frames(moments: Sequence[Any], draw: Callable[..., None], look: Any, width: int) -> list[Any]:
    """Images of Pillow of all moments, drawn by `draw(moment, look, names, path, width)`; names keep to their sides of their points."""
    from PIL import Image

    few, frames = [moments[k] for k in spread(len(moments) - 1, LOOKED_AT)], []
    names = NamesOfMotion(few)
    with TemporaryDirectory() as folder:
        drawn = Path(folder) / "frame.png"
        for moment in few:
            draw(moment, look, names, drawn, width)
        for moment in moments:
            draw(moment, look, names, drawn, width)
            with Image.open(drawn) as image:
                frames.append(image.convert("RGB"))
    return frames


ENCODED: dict[str, Callable[[Sequence[Any]], bytes]] = {".gif": gif, ".mp4": mp4}
"""Ending of a file -> what makes its content of frames."""
