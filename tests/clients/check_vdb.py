#!/usr/bin/python3
"""Reads an OpenVDB file with OpenVDB itself and compares it with what is expected.

    check_vdb.py FILE.vdb EXPECTED.json

EXPECTED.json is a list, one entry a grid, in any order:

    {"name": "density", "type": "float", "active_voxels": 3,
     "bbox": [[0, 0, -2], [1, 0, 4]],          null for an empty grid
     "sum": 1.5,                               of the active values; [x, y, z] for "vec3s"
     "voxel": 0.0003, "origin": [0, 0, 0]}     metres

Exits with 0 if all agree, 1 if something differs, 2 if the arguments or files cannot be read. Needs
`apt-get install python3-openvdb` and the system's Python.
"""

import json
import math
import sys


def describe(grid):
    """The same facts about a grid as an entry of EXPECTED.json, and the sum of the sizes of its values."""
    vectors = grid.valueTypeName == "vec3s"
    sums = [[], [], []] if vectors else [[]]
    for item in grid.citerOnValues():
        for column, value in zip(sums, item.value if vectors else [item.value]):
            column.append(value * item.count)
    totals = [math.fsum(column) for column in sums]
    size = max(math.fsum(map(abs, column)) for column in sums)
    low, high = grid.evalActiveVoxelBoundingBox()
    found = {
        "name": grid.name,
        "type": grid.valueTypeName,
        "active_voxels": grid.activeVoxelCount(),
        "bbox": [list(low), list(high)] if grid.activeVoxelCount() else None,
        "sum": totals if vectors else totals[0],
        "voxel": list(grid.transform.voxelSize()),
        "origin": list(grid.transform.indexToWorld((0, 0, 0))),
    }
    return found, size


def differences(found, size, expected):
    """One line for each fact that differs."""
    for key in ("type", "active_voxels", "bbox"):
        if found[key] != expected[key]:
            yield f"{key}: expected {expected[key]}, found {found[key]}"

    def far(a, b, tolerance):
        a, b = (x if isinstance(x, list) else [x] for x in (a, b))
        return len(a) != len(b) or not all(abs(x - y) <= tolerance for x, y in zip(a, b))

    voxel = expected["voxel"]
    for key, value, tolerance in (
        ("sum", expected["sum"], 1e-5 * size),
        ("voxel", [voxel] * 3, 1e-9 * voxel),
        ("origin", expected["origin"], 1e-6 * voxel),
    ):
        if far(found[key], value, tolerance):
            yield f"{key}: expected {value}, found {found[key]}"


def main():
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 2
    try:
        import pyopenvdb

        grids, _ = pyopenvdb.readAll(sys.argv[1])
        with open(sys.argv[2], encoding="utf-8") as file:
            expected = {entry["name"]: entry for entry in json.load(file)}
    except (ImportError, OSError, RuntimeError, ValueError, LookupError) as error:
        print(f"{sys.argv[1]}: {error}", file=sys.stderr)
        return 2

    failed = False
    found = {grid.name: grid for grid in grids}
    for name in sorted(found.keys() ^ expected.keys()):
        failed = True
        print(f"{name}: {'not expected' if name in found else 'missing'}")
    for name in sorted(found.keys() & expected.keys()):
        facts, size = describe(found[name])
        lines = list(differences(facts, size, expected[name]))
        failed = failed or bool(lines)
        for line in lines:
            print(f"{name}: {line}")
        if not lines:
            print(f"{name}: {facts['active_voxels']} voxels agree")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
