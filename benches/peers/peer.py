"""Renders a scene of `pelage bench` with Mitsuba, in a process of its own, and tells in JSON what that took.

    peer.py SCENE.toml CONTENT.ply GROUND.ply OUTPUT --spp 1,4,16 --reference 1024 --runs 3 --variant llvm_ad_rgb

Writes OUTPUT-1.exr and so on, and OUTPUT-reference.exr unless it is there.
"""

import argparse
import json
import pathlib
import statistics
import time
import tomllib

PASS = 16
"""Samples that are taken at once for the reference, so that its arrays fit in memory."""


def arguments():
    parser = argparse.ArgumentParser()
    for name in ("scene", "content", "ground", "output"):
        parser.add_argument(name)
    parser.add_argument("--spp", type=lambda text: list(map(int, text.split(","))), required=True)
    parser.add_argument("--reference", type=int, required=True)
    parser.add_argument("--runs", type=int, required=True)
    parser.add_argument("--variant", required=True)
    return parser.parse_args()


def peak():
    """The most memory in use so far, in bytes."""
    with open("/proc/self/status") as status:
        return next(1024 * int(line.split()[1]) for line in status if line.startswith("VmHWM:"))


def taken(work):
    """What `work` makes, and its wall and CPU time in seconds."""
    wall, cpu = time.perf_counter(), time.process_time()
    made = work()
    return made, time.perf_counter() - wall, time.process_time() - cpu


def mesh(mi, path, flat):
    color = {"type": "mesh_attribute", "name": "face_color"}
    matt = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": color}}
    return mi.load_dict({"type": "ply", "filename": path, "face_normals": flat, "bsdf": matt})


def scene(mi, described, meshes):
    camera, [light] = described["camera"]["look_at"], described["light"]
    sun, [width, height] = light["directional"], described["render"]["size"]
    return mi.load_dict(
        {
            "type": "scene",
            # One sample of the sun a path, and none of the material: the sun is a point in the sky.
            "integrator": {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0},
            "sensor": {
                "type": "perspective",
                "fov": camera["fov"],
                "fov_axis": "y",
                "to_world": mi.ScalarTransform4f().look_at(camera["eye"], camera["target"], [0, 1, 0]),
                "film": {
                    "type": "hdrfilm",
                    "width": width,
                    "height": height,
                    "pixel_format": "rgb",
                    "rfilter": {"type": "box"},
                },
                "sampler": {"type": "multijitter"},
            },
            "sun": {
                "type": "directional",
                "direction": sun["direction"],
                "irradiance": {"type": "rgb", "value": sun["illuminance"]},
            },
            **meshes,
        }
    )


def main():
    options = arguments()
    with open(options.scene, "rb") as file:
        described = tomllib.load(file)
    import mitsuba as mi

    mi.set_variant(options.variant)
    import numpy as np

    def render(scene, spp, seed):
        return np.array(mi.render(scene, spp=spp, seed=seed))

    # What the peer does once a process is not counted against it.
    taken(lambda: render(mi.load_dict(mi.cornell_box()), 1, 0))
    program = peak()
    meshes, load, _ = taken(
        lambda: {"content": mesh(mi, options.content, True), "ground": mesh(mi, options.ground, False)}
    )
    world, build, build_cpu = taken(lambda: scene(mi, described, meshes))
    pictures = []
    for spp in options.spp:
        # The first compiles kernels, if the variant does that, and is not counted either.
        first, *runs = [taken(lambda: render(world, spp, 1 + run)) for run in range(options.runs + 1)]
        mi.Bitmap(first[0]).write(f"{options.output}-{spp}.exr")
        render_seconds, cpu_seconds = (statistics.median(run[k] for run in runs) for k in (1, 2))
        pictures.append({"spp": spp, "render": render_seconds, "render_cpu": cpu_seconds, "peak_memory": peak()})
    told = {
        "peer": f"mitsuba {mi.__version__}, {options.variant}",
        "program_memory": program,
        "load": load,
        "build": build,
        "build_cpu": build_cpu,
        "pictures": pictures,
    }
    reference = pathlib.Path(f"{options.output}-reference.exr")
    if not reference.exists():
        passes = max(1, options.reference // PASS)
        mean = sum(render(world, options.reference // passes, 1000 + k) for k in range(passes)) / passes
        mi.Bitmap(mean.astype(np.float32)).write(str(reference))
    print(json.dumps(told))


main()
