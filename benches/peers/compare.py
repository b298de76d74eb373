#!/usr/bin/env python3
"""Scenes of `pelage bench` side by side with a path tracer that renders the same geometry, triangle by triangle.

    benches/peers/compare.py --scene blades-256 --scene blades-4096

The peer is Mitsuba 3, installed from PyPI into an environment of its own under --dir. It gets what `pelage expand`
writes, as lean as can be (lean.py), the same camera, sun and colours, and computes direct light only, as pelage does.
Both run on the same cores, one after the other. What both are measured against is the peer's own picture of many
samples. The fast variant of the peer needs LLVM 16 or later (Debian: libllvm19); DRJIT_LIBLLVM_PATH names it where it
is not found.
"""

import argparse
import glob
import hashlib
import json
import math
import os
import pathlib
import subprocess
import sys
import tomllib
import venv

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PACKAGES = ["mitsuba==3.9.1", "numpy"]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scene", action="append", help="a scene of `pelage bench --list`; may be repeated")
    parser.add_argument("--distance", action="append", choices=["near", "mid", "far"])
    parser.add_argument("--size", default="512x512")
    parser.add_argument("--runs", type=int, default=3, help="of which the median is told")
    parser.add_argument("--spp", type=int, action="append", help="of the peer's pictures [1, 4, 16 and 64]")
    parser.add_argument("--reference", type=int, default=1024, help="samples of what errors are measured against")
    parser.add_argument("--variant", help="of the peer [the fastest that works]")
    parser.add_argument("--pelage", default=ROOT / "target/release/pelage", help="the program")
    parser.add_argument("--dir", type=pathlib.Path, default=ROOT / "target/peers")
    parser.add_argument("--json", type=pathlib.Path)
    return parser.parse_args()


def in_environment(folder):
    """Goes on in an environment that has the peer."""
    python = folder / "venv/bin/python"
    if pathlib.Path(sys.prefix) == folder / "venv":
        return
    if not python.exists():
        venv.create(folder / "venv", with_pip=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", *PACKAGES], check=True)
    os.execv(python, [python, *sys.argv])


def variant():
    """The fastest variant of the peer that works here."""
    if "DRJIT_LIBLLVM_PATH" not in os.environ:
        known = [path for n in range(21, 15, -1) for path in glob.glob(f"/usr/lib/*/libLLVM-{n}.so*")]
        if not known:
            print("no LLVM 16 or later: the peer's scalar variant is half as fast", file=sys.stderr)
            return "scalar_rgb"
        os.environ["DRJIT_LIBLLVM_PATH"] = known[0]
    return "llvm_ad_rgb"


def told(command):
    """What a program writes to stdout."""
    return subprocess.run(list(map(str, command)), check=True, stdout=subprocess.PIPE).stdout


class Sight:
    """A scene from a distance, both ways."""

    def __init__(self, options, scene, distance):
        self.options, self.scene, self.distance = options, scene, distance
        self.file = options.dir / f"{scene}-{distance}.toml"

    @property
    def pictures(self):
        """What the names of pictures begin with: a scene that is changed has others."""
        digest = hashlib.sha256(self.file.read_bytes()).hexdigest()[:8]
        return self.file.with_name(f"{self.file.stem}-{digest}")

    def pelage(self):
        """What `pelage bench` measures. It writes the scene file, too."""
        report = self.options.dir / f"{self.scene}.json"
        flags = ["--scene", self.scene, "--distance", self.distance, "--cache", self.options.dir]
        flags += ["--size", self.options.size, "--runs", self.options.runs, "--json", report]
        subprocess.run(list(map(str, [self.options.pelage, "bench", *flags])), check=True, stdout=sys.stderr)
        told([self.options.pelage, "render", self.file, "-o", f"{self.pictures}-pelage.exr", "--quiet"])
        [scene] = json.loads(report.read_text())["scenes"]
        curved = next(p for p in scene["pictures"] if p["path"] == "curved")
        keys = ("boxes", "triangles", "peak_memory", "seconds", "frame")
        return {**{key: scene[key] for key in keys}, "picture": curved}

    def geometry(self):
        """The triangles for the peer; the same from any distance."""
        paths = [self.options.dir / f"{self.scene}-{part}.ply" for part in ("content", "ground")]
        if not all(path.exists() for path in paths):
            from lean import split

            whole = self.options.dir / f"{self.scene}.ply"
            # Content is carried into the boxes triangle by triangle: none is cut.
            cut = ["--tolerance", "100%", "--limit", "16GiB", "--quiet"]
            told([self.options.pelage, "expand", self.file, "-o", whole, *cut])
            [ground] = tomllib.loads(self.file.read_text())["geometry"]
            split(whole, 2 * math.prod(ground["patches"]), *paths)
            whole.unlink()
        return paths

    def peer(self):
        """What the peer takes."""
        samples = ",".join(map(str, self.options.spp))
        flags = ["--spp", samples, "--reference", self.options.reference]
        flags += ["--runs", self.options.runs, "--variant", self.options.variant]
        return json.loads(told([sys.executable, HERE / "peer.py", self.file, *self.geometry(), self.pictures, *flags]))

    def error(self, picture):
        """Root of the mean square of differences in linear radiance, where a white wall that faces the sun is 1."""
        import mitsuba
        import numpy

        mitsuba.set_variant("scalar_rgb")
        # After the colour come depth and alpha, if they are there.
        shown, reference = (
            numpy.array(mitsuba.Bitmap(f"{self.pictures}-{name}.exr"))[..., :3] for name in (picture, "reference")
        )
        return float(numpy.sqrt(numpy.mean((shown - reference) ** 2)))

    def compared(self):
        """Both, and the peer at pelage's error."""
        ours, peer = self.pelage(), self.peer()
        ours["error"] = self.error("pelage")
        for picture in peer["pictures"]:
            picture["error"] = self.error(picture["spp"])
        spp, render, render_cpu = at_error(peer["pictures"], ours["error"])
        in_all = peer["load"] + peer["build"] + render
        memory = min(picture["peak_memory"] for picture in peer["pictures"])
        equal = {
            "spp": spp,
            "render": render,
            "in_all": in_all,
            "render_ratio": render / ours["picture"]["seconds"],
            "render_cpu_ratio": render_cpu / ours["picture"]["cpu_seconds"],
            "in_all_ratio": in_all / ours["picture"]["from_file_seconds"],
            "memory_ratio": memory / ours["peak_memory"],
        }
        return {"scene": self.scene, "distance": self.distance, "pelage": ours, "peer": peer, "at_equal_error": equal}


def at_error(pictures, error):
    """How many samples, and what seconds of wall and CPU a picture, the peer needs for an error: between (and beyond)
    what was measured, errors are powers of samples and times are linear. Never less than its fewest samples."""
    if error >= pictures[0]["error"]:
        return tuple(pictures[0][key] for key in ("spp", "render", "render_cpu"))
    a, b = next(((a, b) for a, b in zip(pictures, pictures[1:]) if error >= b["error"]), pictures[-2:])
    power = math.log(b["error"] / a["error"]) / math.log(b["spp"] / a["spp"])
    spp = a["spp"] * (error / a["error"]) ** (1 / power)
    part = (spp - a["spp"]) / (b["spp"] - a["spp"])
    return spp, *(a[key] + part * (b[key] - a[key]) for key in ("render", "render_cpu"))


def table(row):
    """A comparison, for people."""
    ours, peer, equal = row["pelage"], row["peer"], row["at_equal_error"]
    seconds, picture = ours["seconds"], ours["picture"]

    def line(name, load, build, render, cpu, memory, error):
        times = f"{load:6.3f} {build:7.3f} {render:7.3f} {cpu:7.3f} {load + build + render:9.3f}"
        return f"  {name:8}{times} {memory / (1 << 20):9.1f}  {error:.4f}"

    lines = [
        f"{row['scene']}, {row['distance']}: {ours['boxes']} boxes, {ours['triangles'] / 1e6:.2f} M triangles;"
        f" {peer['peer']}",
        "            load   build  render     CPU  all in s  peak MiB   RMSE",
        line(
            "pelage",
            seconds["load"],
            seconds["extrude"] + seconds["compile"],
            picture["seconds"],
            picture["cpu_seconds"],
            ours["peak_memory"],
            ours["error"],
        ),
    ]
    for p in peer["pictures"]:
        lines.append(
            line(
                f"{p['spp']} spp",
                peer["load"],
                peer["build"],
                p["render"],
                p["render_cpu"],
                p["peak_memory"],
                p["error"],
            )
        )
    lines.append(
        f"  At pelage's error the peer takes {equal['spp']:.1f} samples, {equal['render']:.3f} s to render and"
        f" {equal['in_all']:.3f} s in all:\n  pelage is {equal['render_ratio']:.2f} (by CPU"
        f" {equal['render_cpu_ratio']:.2f}) and {equal['in_all_ratio']:.2f} times as fast,"
        f" in 1/{equal['memory_ratio']:.1f} of the memory."
    )
    if ours["frame"]:
        frame = ours["frame"]["total"]
        lines.append(
            f"  A frame that moves takes pelage {frame:.3f} s: {equal['in_all'] / frame:.2f} times as fast as the peer,"
            " which loads and builds anew."
        )
    return "\n".join(lines)


def main():
    options = arguments()
    options.dir = options.dir.resolve()
    options.dir.mkdir(parents=True, exist_ok=True)
    in_environment(options.dir)
    options.variant = options.variant or variant()
    options.spp = sorted(set(options.spp or [1, 4, 16, 64]))
    rows = []
    for scene in options.scene or ["blades-256", "blades-4096"]:
        for distance in options.distance or ["mid", "far"]:
            rows.append(Sight(options, scene, distance).compared())
            print(table(rows[-1]), flush=True)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=2) + "\n")


main()
