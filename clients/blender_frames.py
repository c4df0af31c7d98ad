"""Run by Blender's Python: import a face, evaluate frames, write what stands there, render one picture.

blender_frames.py FILE RATE OUT.npz OUT.png FRAME ...
"""

import sys
from fractions import Fraction
from pathlib import Path

import bpy
import numpy as np

source, rate, numbers, picture, *frames = sys.argv[1:]

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
fraction = Fraction(rate).limit_denominator(1001)
scene.render.fps = round(float(fraction) + 0.4999)
scene.render.fps_base = scene.render.fps / float(fraction)
IMPORTERS = {
    ".glb": lambda path: bpy.ops.import_scene.gltf(filepath=path),
    ".abc": lambda path: bpy.ops.wm.alembic_import(filepath=path, as_background_job=False),
}
IMPORTERS.get(Path(source).suffix, lambda path: bpy.ops.wm.usd_import(filepath=path))(source)

face = max((o for o in scene.objects if o.type == "MESH"), key=lambda o: len(o.data.vertices))
keys = face.data.shape_keys
names = [] if keys is None else [key.name for key in keys.key_blocks[1:]]


def evaluated(frame: int) -> tuple[np.ndarray, np.ndarray]:
    """World positions and corner normals, Blender's axes, metres."""
    scene.frame_set(frame)
    moved = face.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = moved.to_mesh()
    points = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.vertices.foreach_get("co", points)
    normals = np.empty(len(mesh.loops) * 3, np.float32)
    mesh.corner_normals.foreach_get("vector", normals)
    corners = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    place = np.array(moved.matrix_world, np.float64)
    by_vertex = np.zeros((len(mesh.vertices), 3))
    np.add.at(by_vertex, corners, normals.reshape(-1, 3))
    return points.reshape(-1, 3) @ place[:3, :3].T + place[:3, 3], by_vertex @ place[:3, :3].T


found = [evaluated(int(frame)) for frame in frames]
np.savez(
    numbers,
    points=np.stack([points for points, _ in found]),
    normals=np.stack([normals for _, normals in found]),
    names=np.array(names),
    fps=scene.render.fps / scene.render.fps_base,
    range=np.array([scene.frame_start, scene.frame_end]),
)

middle = found[-1][0].mean(axis=0)
camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
camera.location = (middle[0], middle[1] - 0.65, middle[2])
camera.rotation_euler = (np.pi / 2, 0, 0)
light = bpy.data.objects.new("light", bpy.data.lights.new("light", "SUN"))
light.data.energy = 3
light.rotation_euler = (0.8, 0.3, 0)
for thing in (camera, light):
    scene.collection.objects.link(thing)
scene.camera = camera
scene.world = bpy.data.worlds.new("grey")
scene.world.color = (0.2, 0.22, 0.25)
scene.render.engine = "CYCLES"
scene.cycles.samples = 16
scene.cycles.use_denoising = False
scene.render.resolution_x = scene.render.resolution_y = 384
scene.render.filepath = picture
bpy.ops.render.render(write_still=True)
