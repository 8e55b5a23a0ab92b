"""Opens this take in Blender 3.4 or later: the surfaces with colours and velocities, and the volumes.

    blender --python blender_import.py
    blender -b --factory-startup --python-exit-code 1 --python blender_import.py -- --render frame.png --frame 12

Surfaces are one object a frame, shown on that frame alone. Files are y up, Blender is z up: it turns OBJ files itself,
volumes are turned here. Point attributes (velocity [m/s], pressure, ...) are taken from ply/ if it is there.
"""

import argparse
import json
import math
import os
import sys

import bpy
import numpy

TAKE = json.loads("""@TAKE@""")
HERE = os.path.dirname(os.path.abspath(__file__))


def read_ply(path):
    """Rows of the vertices of a PLY file that osteoflow wrote."""
    kinds = {"float": "<f4", "uchar": "u1"}
    with open(path, "rb") as file:
        columns, vertices, of_vertices = [], 0, False
        for line in iter(file.readline, b"end_header\n"):
            words = line.decode("ascii").split()
            if words[0] == "element":
                of_vertices = words[1] == "vertex"
                vertices = int(words[2]) if of_vertices else vertices
            elif words[0] == "property" and of_vertices:
                columns.append((words[2], kinds[words[1]]))
        return numpy.fromfile(file, dtype=columns, count=vertices)


def add_attributes(mesh, path):
    rows = read_ply(path)
    if len(rows) != len(mesh.vertices):
        raise RuntimeError(f"{path}: {len(rows)} vertices, its OBJ has {len(mesh.vertices)}")
    velocity = [rows["velocity_x"], -rows["velocity_z"], rows["velocity_y"]]
    attribute = mesh.attributes.new("velocity", "FLOAT_VECTOR", "POINT")
    attribute.data.foreach_set("vector", numpy.stack(velocity, 1).astype("f4").ravel())
    for name in TAKE["numbers"]:
        attribute = mesh.attributes.new(name, "FLOAT", "POINT")
        attribute.data.foreach_set("value", numpy.ascontiguousarray(rows[name]))


def show_on(thing, frame):
    for at, hidden in ((frame - 1, True), (frame, False), (frame + 1, True)):
        thing.hide_viewport = thing.hide_render = hidden
        thing.keyframe_insert("hide_viewport", frame=at)
        thing.keyframe_insert("hide_render", frame=at)
    for curve in thing.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "CONSTANT"


def cement():
    material = bpy.data.materials.new("Cement")
    material.use_nodes = True
    nodes = material.node_tree
    colour = nodes.nodes.new("ShaderNodeVertexColor")
    colour.layer_name = "Color"
    shader = nodes.nodes["Principled BSDF"]
    shader.inputs["Roughness"].default_value = 0.35
    nodes.links.new(colour.outputs["Color"], shader.inputs["Base Color"])
    return material


def import_surfaces(frames):
    material = cement()
    things = {}
    for frame in frames:
        path = os.path.join(HERE, "surface", f"cement.{frame:04}.obj")
        # The start may have no cement yet, and only some frames may have been written.
        if not os.path.exists(path):
            continue
        before = set(bpy.data.objects)
        bpy.ops.wm.obj_import(filepath=path, forward_axis="NEGATIVE_Z", up_axis="Y")
        for thing in set(bpy.data.objects) - before:
            ply = os.path.join(HERE, "ply", f"cement.{frame:04}.ply")
            if os.path.exists(ply):
                add_attributes(thing.data, ply)
            thing.data.materials.clear()
            thing.data.materials.append(material)
            show_on(thing, frame)
            things[frame] = thing
    return things


def import_volume(frames):
    folder = os.path.join(HERE, "vdb") + os.sep
    frames = [frame for frame in frames if os.path.exists(f"{folder}cement.{frame:04}.vdb")]
    files = [{"name": f"cement.{frame:04}.vdb"} for frame in frames]
    before = set(bpy.data.objects)
    bpy.ops.object.volume_import(
        filepath=folder + files[0]["name"], directory=folder, files=files, align="WORLD", location=(0, 0, 0)
    )
    (thing,) = set(bpy.data.objects) - before
    thing.name = "Cement volume"
    thing.rotation_euler = (math.pi / 2, 0, 0)
    volume = thing.data
    volume.is_sequence = len(frames) > 1
    volume.frame_start = frames[0]
    volume.frame_offset = frames[0] - 1
    volume.frame_duration = len(frames)
    # The name is looked for among the grids, so one file has to be open.
    bpy.context.scene.frame_set(frames[0])
    volume.grids.load()
    volume.velocity_grid = TAKE["velocity"]
    volume.velocity_unit = "SECOND"
    # Where the surface is shown, the fog is for those who ask for it.
    thing.hide_render = True
    return thing


def import_take(frames=None):
    frames = frames or TAKE["frames"]
    scene = bpy.context.scene
    scene.unit_settings.system = "METRIC"
    scene.frame_start, scene.frame_end = frames[0], frames[-1]
    scene.render.fps = max(1, round(TAKE["frames_per_second"]))
    scene.render.fps_base = scene.render.fps / TAKE["frames_per_second"]
    return import_surfaces(frames), import_volume(frames)


def render(path, things, frame):
    """A picture of one frame, lit from above."""
    scene = bpy.context.scene
    scene.frame_set(frame)
    thing = things[frame]
    # A new scene comes with a cube, two metres wide, and a lamp.
    for other in set(scene.objects) - set(things.values()):
        other.hide_render = True
    corners = numpy.array([thing.matrix_world @ vertex.co for vertex in thing.data.vertices])
    low, high = corners.min(0), corners.max(0)
    size = float(numpy.linalg.norm(high - low))
    middle = (low + high) / 2
    eye = bpy.data.objects.new("Eye", bpy.data.cameras.new("Eye"))
    eye.location = middle + numpy.array((0.6, -1.5, 0.8)) * size
    eye.data.clip_start = size / 100
    target = bpy.data.objects.new("Target", None)
    target.location = middle
    look = eye.constraints.new("TRACK_TO")
    look.target, look.track_axis, look.up_axis = target, "TRACK_NEGATIVE_Z", "UP_Y"
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 3, (0.6, 0.3, 0)
    for added in (eye, target, sun):
        scene.collection.objects.link(added)
    scene.camera = eye
    scene.world = bpy.data.worlds.new("Sky")
    scene.world.color = (0.6, 0.65, 0.7)
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 16
    scene.cycles.use_denoising = False
    scene.render.resolution_x, scene.render.resolution_y = 480, 360
    scene.render.filepath = os.path.abspath(path)
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--render", help="a PNG to render")
    parser.add_argument("--frame", type=int, default=TAKE["frames"][-1])
    parser.add_argument("--save", help="a .blend file to write")
    given = parser.parse_args(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else [])
    shown, _ = import_take()
    if given.render:
        render(given.render, shown, given.frame)
    if given.save:
        bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(given.save))
