"""Bakes scenes with Umbrage and with others, and prints seconds and error of each.

Error is the relative root mean square error of the irradiance at the points of testdata/reference, as docs/convergence.md has it.
Seconds are those of light alone for the others, without reading the scene, and of the whole process for Umbrage. All use all
processors.
"""

import argparse
import importlib

import by_umbrage
from points import ROOT, SCENES, error_of_triangles

OTHERS = ["cycles", "mitsuba", "radiance"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", default="cornell,touching", help="with commas between: " + ", ".join(SCENES))
    parser.add_argument("--by", default=",".join(OTHERS), help="with commas between: " + ", ".join(OTHERS))
    parser.add_argument("--size", type=int, default=512, help="texels on a side of Cycles' lightmap")
    parser.add_argument("--samples", type=int, default=64, help="paths from each texel")
    parser.add_argument("--vertex-samples", type=int, default=256, help="paths from each vertex")
    parser.add_argument("--tolerance", type=float, default=0.01, help="of Umbrage")
    parser.add_argument("--umbrage", default=ROOT / "target/release/umbrage", help="the program")
    args = parser.parse_args()
    others = [importlib.import_module(f"by_{name}") for name in args.by.split(",")]
    rows = [["scene", "by", "seconds", "error", "of what"]]
    for scene in args.scenes.split(","):
        seconds, baked = by_umbrage.bake(args.umbrage, scene, args.tolerance)
        wrong = error_of_triangles(scene, baked.positions[baked.triangles], baked.irradiance[baked.triangles])
        found = [("Umbrage", seconds, wrong, f"{len(baked.positions)} vertices, {len(baked.triangles)} triangles")]
        for other in others:
            found += other.rows(scene, baked, args)
        rows += [[scene, by, f"{seconds:.2f}", f"{wrong:.2%}", of] for by, seconds, wrong, of in found]
    widths = [max(len(row[i]) for row in rows) for i in range(5)]
    rows.insert(1, ["-" * width for width in widths])
    for row in rows:
        print("| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths)) + " |")


if __name__ == "__main__":
    main()
