"""Moving pictures: drawn instants one after the other in a GIF file or an MP4 file."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Sequence
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, TypeAlias, TypeVar

import numpy as np

from toolkit.foundation.near_ties import first_largest, spread
from toolkit.render.label_places import NamesOfMotion
from toolkit.render.moment import Moment
from toolkit.render.packages import RenderError

if TYPE_CHECKING:
    from PIL import Image

M = TypeVar("M", bound=Moment)
L = TypeVar("L")
DrawInstant: TypeAlias = Callable[[M, L, NamesOfMotion | None, Path, int], None]
"""Function that draws a moment with a look, and with the names of its motion if it is of one, and writes it to a path, in pixels."""

ALIKE = 0.1
"""Two instants look alike if no point is further from its other place than this part of the longest way between any two instants,
and their largest stresses do not differ by this part of the largest of all."""
STILL = 1e-9
"""A motion that nobody sees, relative to the largest coordinate."""
COMPARED_INSTANTS = 120
"""Instants of a motion at most that are compared, beside that of the largest stress, which is sought among all."""


def telling_steps(count: int, points: Callable[[int], np.ndarray], stress: np.ndarray) -> list[int]:
    """Numbers of steps of a motion to draw.

    These are the last one, that of the largest stress, the one at which a point is furthest from where it started, and the start, without
    those that look like another; where there are fewer than wanted, more that are each as different from the others as can be.

    Parameters
    ----------
    count : int
        How many are wanted at most.
    points : callable
        Number of a step -> where what is drawn is, (n, d), the same points at all steps.
    stress : (n_t,)
        Largest stress at every step; zero where there is none.

    Returns
    -------
    chosen : list of int
        Rising numbers, at most `count`; the last step is among them.
    """
    last, peak = len(stress) - 1, first_largest(stress)
    steps = sorted({*spread(last, COMPARED_INSTANTS), peak})
    places, end = np.array([points(step) for step in steps]), len(steps) - 1
    if not places.size:
        return spread(last, count)
    apart, loud = _apart(places), stress[steps]

    def alike(a: int, b: int) -> bool:
        return apart(a)[b] <= near and abs(loud[a] - loud[b]) <= ALIKE * loud.max()

    near = max(ALIKE * apart(end).max(), STILL * np.abs(places).max())  # twice the first bounds the way between any two instants
    chosen = [end]
    for k in (steps.index(peak), first_largest(apart(0)), 0):
        if len(chosen) < count and not any(alike(k, other) for other in chosen):
            chosen.append(k)
    while len(chosen) < count:
        nearest = np.min([apart(k) for k in chosen], axis=0)
        k = first_largest(nearest)
        if nearest[k] <= near:
            break
        chosen.append(k)
    return sorted(steps[k] for k in chosen)


def _apart(places: np.ndarray) -> Callable[[int], np.ndarray]:
    """Function from an instant's number to the longest displacement of any point from there to every instant, (n_t,)."""
    return lambda k: np.asarray(np.linalg.norm(places - places[k], axis=-1).max(axis=1))


MOST_FRAMES, DURATION, PAUSE = 60, 4000, 1500
"""Frames at most; ms that a motion takes, and that its last frame stands still."""
LOOKED_AT = 9
"""Frames that are looked at before names get their places and pictures their colours."""


def mp4(frames: Sequence[Image.Image]) -> bytes:
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


def gif(frames: Sequence[Image.Image]) -> bytes:
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


def drawn_frames(moments: Sequence[M], draw: DrawInstant[M, L], look: L, width: int) -> list[Image.Image]:
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


ENCODED: dict[str, Callable[[Sequence[Image.Image]], bytes]] = {".gif": gif, ".mp4": mp4}
"""Ending of a file -> what makes its content of frames."""
