"""Renders the views of a Blender scene from cameras in a row, and makes their quilt and Native.

    blender scene.blend --background --python blender_quilt.py -- visual.json out/

The scene's camera is the middle one. What lies in its focus distance appears on the panel's surface.
Blender's own Python must find altiro3d: start it with PYTHONPATH=/usr/lib/python3/dist-packages if
both have the same version of Python.
"""
import math
import sys
from pathlib import Path

import numpy

import altiro3d


def camera_row(view_count, cone_degrees, distance, angle):
    """Position to the right, and shift of the picture in its longer sides, of each camera.

    The cameras look in parallel, and their pictures are shifted so that all show the same part of
    the plane at `distance`. cone_degrees: angle between the outermost cameras, seen from that plane;
    angle: field of view of the longer side, radians.
    """
    half = distance * math.tan(math.radians(cone_degrees) / 2)
    for view in range(view_count):
        right = half * altiro3d.view_position(view, view_count)
        yield right, -right / (2 * distance * math.tan(angle / 2))


def make_pictures(files, display, folder):
    """Makes quilt and Native of the views' files, leftmost camera first. Returns their names."""
    layout = display.quilt
    width, height = layout.size()
    quilt = numpy.zeros((height, width, 3), numpy.uint8)
    for view, file in enumerate(files):
        x, y, columns, rows = layout.tile(view)
        quilt[y:y + rows, x:x + columns] = altiro3d.read_photo(file)
    maker = altiro3d.Quilt2Native(display.calibration, layout, invert=display.invert)
    quilt_file = altiro3d.quilt_file_name(folder / "quilt.png", layout, display.aspect())
    altiro3d.write_image(quilt_file, quilt)
    altiro3d.write_image(folder / "native.png", maker.render(quilt), mark=altiro3d.ImageMark.Native)
    return quilt_file, folder / "native.png"


def render_views(display, folder):
    """Renders the views in Blender. Returns their files."""
    import bpy
    from mathutils import Vector

    scene = bpy.context.scene
    camera = scene.camera
    scene.render.resolution_x, scene.render.resolution_y = display.quilt.tile_size
    scene.render.resolution_percentage = 100
    cone = altiro3d.view_cone_degrees(display.calibration)
    distance = camera.data.dof.focus_distance
    start, shift = camera.location.copy(), camera.data.shift_x
    to_the_right = camera.matrix_world.to_3x3() @ Vector((1, 0, 0))
    files = []
    for right, more in camera_row(display.quilt.view_count, cone, distance, camera.data.angle):
        camera.location = start + right * to_the_right
        camera.data.shift_x = shift + more
        files.append(folder / f"view{len(files):02}.png")
        scene.render.filepath = str(files[-1])
        bpy.ops.render.render(write_still=True)
    camera.location, camera.data.shift_x = start, shift
    return files


if __name__ == "__main__":
    calibration, out = sys.argv[sys.argv.index("--") + 1:]
    Path(out).mkdir(exist_ok=True)
    the_display = altiro3d.read_display(calibration)
    print(*make_pictures(render_views(the_display, Path(out)), the_display, Path(out)))
