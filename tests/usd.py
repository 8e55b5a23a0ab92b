"""Opens a take's scene with USD's own library and checks it as a client would use it.

    python tests/usd.py TAKE
"""

import os
import sys

from pxr import Usd, UsdGeom, UsdVol

take = sys.argv[1]
stage = Usd.Stage.Open(os.path.join(take, "scene.usda"))
assert UsdGeom.GetStageUpAxis(stage) == "Y"
assert UsdGeom.GetStageMetersPerUnit(stage) == 1
assert stage.GetTimeCodesPerSecond() == 100
assert stage.GetDefaultPrim().GetPath() == "/Take"
first, last = int(stage.GetStartTimeCode()), int(stage.GetEndTimeCode())
assert (first, last) == (0, 2)

mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/Take/Cement"))
assert mesh.GetPointsAttr().GetNumTimeSamples() == last - first + 1
primvars = UsdGeom.PrimvarsAPI(mesh)
seen = []
for time in range(first, last + 1):
    points = mesh.GetPointsAttr().Get(time)
    corners = mesh.GetFaceVertexIndicesAttr().Get(time)
    counts = mesh.GetFaceVertexCountsAttr().Get(time)
    assert len(points) > 100 and set(counts) == {3} and len(corners) == 3 * len(counts)
    assert 0 <= min(corners) and max(corners) < len(points)
    # The same as the OBJ of that frame, which has a line a vertex.
    with open(os.path.join(take, "surface", f"cement.{time:04}.obj")) as obj:
        places = [line.split()[1:4] for line in obj if line.startswith("v ")]
    assert len(places) == len(points)
    assert all(abs(float(a) - b) < 2e-7 for p, q in zip(places, points) for a, b in zip(p, q))
    low, high = mesh.GetExtentAttr().Get(time)
    assert all(low[k] - 2e-7 <= p[k] <= high[k] + 2e-7 for p in points for k in range(3))
    for name in ["displayColor", "polymer_fraction", "speed", "pressure", "shear_rate", "millilitre"]:
        primvar = primvars.GetPrimvar(name)
        assert primvar.GetInterpolation() == "vertex", name
        assert len(primvar.Get(time)) == len(points), name
    assert len(mesh.GetVelocitiesAttr().Get(time)) == len(points)
    assert len(mesh.GetNormalsAttr().Get(time)) == len(points)
    volume = UsdVol.Volume(stage.GetPrimAtPath("/Take/Volume"))
    fields = volume.GetFieldPaths()
    assert set(fields) == {"density", "polymer", "velocity", "surface"}, fields
    for path in fields.values():
        file = UsdVol.OpenVDBAsset(stage.GetPrimAtPath(path)).GetFilePathAttr().Get(time)
        assert file.path.endswith(f"cement.{time:04}.vdb") and os.path.exists(file.resolvedPath)
    seen.append(points)
assert seen[0] != seen[-1]
print("a scene of", len(seen), "frames")
