#!/usr/bin/env python3
"""Writes relief.glb: a disc with ripples, tagged to be touched, its middle a hollow, 12 to 17 mm above the hull. tests/scripts compares the file.

  tests/engines/godot/relief.py FILE"""
import json
import math
import struct
import sys

RADIUS_m, TOP_m, BOTTOM_m = 0.026, 0.0520, 0.046
RIPPLE_m, LENGTH_m, FADING_m = 0.0022, 0.0155, 0.025
RINGS, SECTORS = 36, 72
HAPTIC = {"stiffness": 600, "damping": 0.5, "staticFriction": 0.35, "dynamicFriction": 0.3}


def height_m(r_m):
    return TOP_m - RIPPLE_m * math.cos(2 * math.pi * r_m / LENGTH_m) * math.exp(-r_m / FADING_m)


def slope(r_m):
    phase = 2 * math.pi * r_m / LENGTH_m
    return RIPPLE_m * math.exp(-r_m / FADING_m) * (2 * math.pi / LENGTH_m * math.sin(phase) + math.cos(phase) / FADING_m)


def mesh():
    """Points and normals, y up, and triangles: the middle, rings outwards, a wall, the underside."""
    points, normals, triangles = [(0, height_m(0), 0)], [(0, 1, 0)], []

    def add_ring(r_m, y_m, radial, up):
        size = math.hypot(radial, up)
        first = len(points)
        for k in range(SECTORS):
            c, s = math.cos(2 * math.pi * k / SECTORS), math.sin(2 * math.pi * k / SECTORS)
            points.append((r_m * c, y_m, r_m * s))
            normals.append((radial * c / size, up / size, radial * s / size))
        return first

    def join(inner, outer):
        for k in range(SECTORS):
            n = (k + 1) % SECTORS
            triangles.extend([(inner + k, inner + n, outer + n), (inner + k, outer + n, outer + k)])

    ring = None
    for i in range(1, RINGS + 1):
        r_m = RADIUS_m * i / RINGS
        following = add_ring(r_m, height_m(r_m), -slope(r_m), 1)
        if ring is None:
            triangles.extend((0, following + (k + 1) % SECTORS, following + k) for k in range(SECTORS))
        else:
            join(ring, following)
        ring = following
    join(add_ring(RADIUS_m, height_m(RADIUS_m), 1, 0), add_ring(RADIUS_m, BOTTOM_m, 1, 0))
    rim = add_ring(RADIUS_m, BOTTOM_m, 0, -1)
    points.append((0, BOTTOM_m, 0))
    normals.append((0, -1, 0))
    triangles.extend((len(points) - 1, rim + k, rim + (k + 1) % SECTORS) for k in range(SECTORS))
    return points, normals, triangles


def glb():
    points, normals, triangles = mesh()
    # Rounded, so that another sine gives the same bytes.
    vectors = [b"".join(struct.pack("<3f", *(round(x, 6) + 0.0 for x in v)) for v in list_) for list_ in (points, normals)]
    indices = b"".join(struct.pack("<3H", *t) for t in triangles)
    binary = b"".join([*vectors, indices])
    binary += bytes(-len(binary) % 4)
    axes = list(zip(*(struct.unpack("<3f", vectors[0][i:i + 12]) for i in range(0, len(vectors[0]), 12))))
    size = len(vectors[0])
    document = {
        "asset": {"version": "2.0", "generator": "relief.py", "copyright": "Apache-2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "relief", "mesh": 0, "extras": {"haptic": HAPTIC}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.05, 0.32, 0.38, 1], "metallicFactor": 0.0, "roughnessFactor": 0.35}}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3",
                       "min": [min(a) for a in axes], "max": [max(a) for a in axes]},
                      {"bufferView": 1, "componentType": 5126, "count": len(points), "type": "VEC3"},
                      {"bufferView": 2, "componentType": 5123, "count": 3 * len(triangles), "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": size, "target": 34962},
                        {"buffer": 0, "byteOffset": size, "byteLength": size, "target": 34962},
                        {"buffer": 0, "byteOffset": 2 * size, "byteLength": len(indices), "target": 34963}],
        "buffers": [{"byteLength": len(binary)}]}
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    parts = struct.pack("<2I", len(text), 0x4E4F534A) + text + struct.pack("<2I", len(binary), 0x004E4942) + binary
    return struct.pack("<3I", 0x46546C67, 2, 12 + len(parts)) + parts


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: relief.py FILE")
    with open(sys.argv[1], "wb") as out:
        out.write(glb())
