"""Draws the panel of the add-on beside a rig that plays a plan. Run by scripts/update-blender-pictures inside Blender.

    blender --enable-event-simulate FILE.blend --python blender-panel.py -- ADD_ON PROGRAM RIG.toml PLAN.csv URDF PICTURE
"""
import importlib.util
import os
import sys

import bpy
import mathutils

ADD_ON, PROGRAM, RIG, PLAN, URDF, PICTURE = sys.argv[sys.argv.index("--") + 1:]
FRAME = 90  # the boom is up and the column swings


def set_the_scene():
    """The crane alone, on a frame of its plan, and what its check says in the panel."""
    spec = importlib.util.spec_from_file_location("inbetween_blender", ADD_ON)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.register()
    scene = bpy.context.scene
    for name in ("Cube", "Light", "Camera"):
        bpy.data.objects.remove(bpy.data.objects[name])
    crane = bpy.data.objects["crane"]
    bpy.context.view_layer.objects.active = crane
    crane.data.show_names = True
    scene.frame_start, scene.frame_end = 1, 289
    scene.frame_set(FRAME)
    fields = scene.inbetween
    fields.rig, fields.import_path, fields.urdf, fields.program = RIG, PLAN, URDF, PROGRAM
    bpy.ops.inbetween.check_motion()
    # Names are enough in the picture; the folders of this machine are of no use.
    os.chdir(os.path.dirname(RIG))
    fields.rig, fields.import_path, fields.urdf = (os.path.basename(path) for path in (RIG, PLAN, URDF))
    fields.program = ""


def view():
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    return window, area, {region.type: region for region in area.regions}


def look():
    """The sidebar is open, and the crane is in the middle of what it leaves free."""
    _, area, regions = view()
    space = area.spaces.active
    space.show_region_ui = True
    space.show_region_toolbar = False
    space.overlay.show_relationship_lines = False
    region = space.region_3d
    region.view_rotation = mathutils.Euler((1.25, 0, 0.35), "XYZ").to_quaternion()
    region.view_location, region.view_distance = (2.9, -0.4, 0.55), 5.5
    for part in regions.values():
        part.tag_redraw()


def press_the_tab():
    """The last tab of the sidebar, by the pointer, as there is no other way in Blender 3.4."""
    window, area, regions = view()
    sidebar = regions["UI"]
    x = sidebar.x + sidebar.width - 12
    y = sidebar.y + sidebar.height - TAB_BELOW_TOP
    for kind, value in (("MOUSEMOVE", "NOTHING"), ("LEFTMOUSE", "PRESS"), ("LEFTMOUSE", "RELEASE")):
        window.event_simulate(type=kind, value=value, x=x, y=y)


def take_picture():
    window, area, regions = view()
    with bpy.context.temp_override(window=window, area=area, region=regions["WINDOW"]):
        bpy.ops.screen.screenshot(filepath=PICTURE)


TAB_BELOW_TOP = 160  # the middle of the fourth tab, at the size of the window that the script gives
steps = iter((set_the_scene, look, press_the_tab, look, take_picture, bpy.ops.wm.quit_blender))


def next_step():
    """One step a second: Blender draws in between."""
    step = next(steps, None)
    if step is None:
        return None
    step()
    return 1.0


bpy.app.timers.register(next_step, first_interval=2.0)
