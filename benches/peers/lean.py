"""The triangles that `pelage expand` writes, in as little room as a path tracer can take them.

`pelage expand` gives every triangle three vertices of its own, each with a normal and a colour. A peer would pay for
that in time and memory, so what is measured is given to it lean: shared vertices, flat shading, one colour a triangle;
only the ground, which is a surface with normals of its own, keeps them.
"""

import numpy as np

VERTEX = np.dtype([("p", "<f4", 3), ("n", "<f4", 3), ("c", "u1", 3)])
CHUNK = 1 << 20


def linear(srgb):
    """Linear colours in [0, 1] of 8-bit sRGB."""
    x = np.arange(256) / 255.0
    table = np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4).astype("<f4")
    return table[srgb]


def shared(points):
    """Points that are each there once, and by corner which of them it is."""
    keys = np.ascontiguousarray(points).view("V12").ravel()
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    return points[first], inverse.astype("<u4").reshape(-1, 3)


def triangles(path):
    """The vertices of a file of `pelage expand`, three a triangle, without loading them."""
    with open(path, "rb") as file:
        count = 0
        while (line := file.readline()) != b"end_header\n":
            if line.startswith(b"element vertex"):
                count = int(line.split()[2])
        return np.memmap(path, VERTEX, "r", file.tell(), (count // 3, 3))


def write(path, vertices, faces, colors, normals=None):
    """A binary PLY file, of lists of chunks."""
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {sum(map(len, vertices))}"]
    header += [f"property float {name}" for name in ("x", "y", "z")]
    if normals:
        header += [f"property float {name}" for name in ("nx", "ny", "nz")]
    header += [f"element face {sum(map(len, faces))}", "property list uchar uint vertex_indices"]
    header += [f"property float {name}" for name in ("r", "g", "b")]
    with open(path, "wb") as file:
        file.write(("\n".join(header) + "\nend_header\n").encode())
        for number, chunk in enumerate(vertices):
            file.write((np.hstack([chunk, normals[number]]) if normals else chunk).astype("<f4").tobytes())
        for chunk, color in zip(faces, colors):
            rows = np.empty(len(chunk), [("count", "u1"), ("corner", "<u4", 3), ("color", "<f4", 3)])
            rows["count"], rows["corner"], rows["color"] = 3, chunk, color
            file.write(rows.tobytes())


def split(path, ground, content_path, ground_path):
    """Writes content and ground apart. The last `ground` triangles of the file are the ground's."""
    all_triangles = triangles(path)
    count = len(all_triangles) - ground
    vertices, faces, colors, first = [], [], [], 0
    for begin in range(0, count, CHUNK):
        part = all_triangles[begin : min(begin + CHUNK, count)]
        points, corners = shared(part["p"].reshape(-1, 3))
        vertices.append(points)
        faces.append(corners + np.uint32(first))
        colors.append(linear(part["c"][:, 0]))
        first += len(points)
    write(content_path, vertices, faces, colors)
    part = all_triangles[count:]
    corners = np.arange(3 * ground, dtype="<u4").reshape(-1, 3)
    points, normals = (part[name].reshape(-1, 3) for name in ("p", "n"))
    write(ground_path, [points], [corners], [linear(part["c"][:, 0])], [normals])
    return {"triangles": len(all_triangles), "vertices": first + 3 * ground}
