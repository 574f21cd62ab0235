"""One picture by F3D, without a window: MODEL PICTURE SIDE [EYE TARGET ANGLE], with the settings of its library."""

import sys

import f3d

model, picture, side, *camera = sys.argv[1:]
f3d.Engine.autoload_plugins()
# Surfaceless EGL of Mesa; where there is none, its library for pictures in memory.
try:
    engine = f3d.Engine.create_egl()
except RuntimeError:
    engine = f3d.Engine.create_osmesa()
engine.window.size = int(side), int(side)
try:
    engine.scene.add(model)
except Exception as error:
    sys.exit(f"F3D: {error}")
if camera:
    *places, angle = map(float, camera)
    engine.window.camera.position = tuple(places[:3])
    engine.window.camera.focal_point = tuple(places[3:])
    engine.window.camera.view_up = (0.0, 1.0, 0.0)
    engine.window.camera.view_angle = angle
shown = engine.window.render_to_image(True)
# It does not fail where its reader has failed, but shows nothing.
if not any(shown.content[3::4]):
    sys.exit("F3D: an empty picture")
shown.save(picture)
