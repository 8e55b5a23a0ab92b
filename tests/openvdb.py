"""OpenVDB's own reader against a list of what a file should hold: python3 tests/openvdb.py FILE.vdb EXPECTED.json"""

import json
import sys

import numpy
import pyopenvdb

path, expected = sys.argv[1:]
expected = json.load(open(expected))
grids = {grid.name: grid for grid in pyopenvdb.readAll(path)[0]}
assert set(grids) == {grid["name"] for grid in expected}, list(grids)
for wanted in expected:
    grid, name = grids[wanted["name"]], wanted["name"]
    assert grid.gridClass == wanted["class"], (name, grid.gridClass)
    for index, place in wanted["places"]:
        assert numpy.allclose(grid.transform.indexToWorld(index), place, rtol=0, atol=1e-12), name
    background = numpy.array(grid.background)
    assert (background == numpy.float32(wanted["background"])).all(), (name, background)
    assert grid.activeVoxelCount() == len(wanted["active"]), name
    voxels = numpy.array([at for at, _ in wanted["active"]]).reshape(-1, 3)
    if len(voxels):
        low, high = grid.evalActiveVoxelBoundingBox()
        assert (voxels.min(0) == low).all() and (voxels.max(0) == high).all(), (name, low, high)
    values = grid.getConstAccessor()
    for at, value in wanted["active"]:
        found, active = values.probeValue(tuple(at))
        assert active and (numpy.array(found) == numpy.float32(value)).all(), (name, at, found, value)
    for at, value in wanted["inactive"]:
        found, active = values.probeValue(tuple(at))
        assert not active and numpy.float32(found) == numpy.float32(value), (name, at, found, value)
print("OpenVDB", pyopenvdb.LIBRARY_VERSION, "agrees")
