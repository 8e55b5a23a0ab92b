"""Opens an exported take through its own script and checks it as a user would see it.

    blender -b --factory-startup --python-exit-code 1 --python tests/blender.py -- TAKE [PICTURE]
"""

import importlib.util
import os
import sys

import bpy
import numpy
from mathutils import Vector

take, *picture = sys.argv[sys.argv.index("--") + 1 :]
spec = importlib.util.spec_from_file_location("blender_import", os.path.join(take, "blender_import.py"))
script = importlib.util.module_from_spec(spec)
spec.loader.exec_module(script)

surfaces, volume = script.import_take()
last = max(surfaces)
bpy.context.scene.frame_set(last)
shown = [frame for frame, thing in surfaces.items() if not thing.hide_render]
assert shown == [last], shown

# Colours, and what else the vertices carry.
mesh = surfaces[last].data
assert len(mesh.vertices) > 100
assert "Color" in mesh.attributes, list(mesh.attributes.keys())
colours = numpy.empty(4 * len(mesh.attributes["Color"].data), "f4")
mesh.attributes["Color"].data.foreach_get("color", colours)
assert colours.min() >= 0 and colours.max() <= 1 and numpy.ptp(colours) > 0.1
velocity = numpy.empty(3 * len(mesh.vertices), "f4")
mesh.attributes["velocity"].data.foreach_get("vector", velocity)
assert numpy.isfinite(velocity).all()
for name in script.TAKE["numbers"]:
    assert len(mesh.attributes[name].data) == len(mesh.vertices), name

# Mesh and volume lie at the same place, within a voxel of a fog that reaches a little beyond.
depsgraph = bpy.context.evaluated_depsgraph_get()
evaluated = volume.evaluated_get(depsgraph)
grids = evaluated.data.grids
assert grids.load(), grids.error_message
names = {grid.name for grid in grids}
assert {"density", "polymer", "surface", script.TAKE["velocity"]} <= names, names
assert volume.data.velocity_grid == script.TAKE["velocity"]
of_mesh = numpy.array([surfaces[last].matrix_world @ v.co for v in mesh.vertices])
of_volume = numpy.array([volume.matrix_world @ Vector(corner) for corner in evaluated.bound_box])
voxel = numpy.abs(numpy.array(grids["density"].matrix_object)).max(0)[:3].max()
low = of_mesh.min(0) - of_volume.min(0)
high = of_volume.max(0) - of_mesh.max(0)
# The level set's band is three voxels wide, and a leaf's box ends a voxel beyond.
assert (low > -voxel).all() and (high > -voxel).all(), (low, high, voxel)
assert (low < 6 * voxel).all() and (high < 6 * voxel).all(), (low, high, voxel)

if picture:
    script.render(picture[0], surfaces, last)
    image = bpy.data.images.load(os.path.abspath(picture[0]))
    pixels = numpy.array(image.pixels[:]).reshape(-1, 4)[:, :3]
    # Cement is teal: more blue than red by far, in a good part of the picture.
    teal = (pixels[:, 2] > pixels[:, 0] + 0.1).mean()
    assert teal > 0.02, teal
print(f"blender {bpy.app.version_string}: {len(surfaces)} surfaces and {sorted(names)} line up")
