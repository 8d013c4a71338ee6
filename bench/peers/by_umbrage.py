"""Umbrage: a bake as a user makes it."""

import pathlib
import subprocess
import tempfile
import time

import files
from points import ROOT


def bake(program, scene, tolerance):
    """Seconds of the whole process, and the baked mesh."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "baked.glb"
        begin = time.perf_counter()
        subprocess.run(
            [program, "bake", "--quiet", ROOT / f"testdata/scenes/{scene}.glb", "-o", out, "--tolerance", str(tolerance)],
            check=True,
        )
        return time.perf_counter() - begin, files.baked(out)
