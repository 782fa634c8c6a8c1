"""Blender and inbetween: motions go out, plans and takes come in, a rig becomes an armature.

As an add-on: Edit > Preferences > Add-ons > Install from disk, this file; then the tab "inbetween" in the sidebar (N)
of a 3D view has four buttons. Without a window:

    blender -b scene.blend --python inbetween_blender.py -- export --object Camera --to camera.csv
    blender -b scene.blend --python inbetween_blender.py -- import plan.csv --object Camera --save played.blend
    blender -b --python inbetween_blender.py -- build crane.urdf --save crane.blend
    blender -b scene.blend --python inbetween_blender.py -- check --object Crane --rig rig.toml

Works in Blender 3.4, 4.x and 5.0, through Blender's documented Python interface and through files. The formats and
conventions are in docs/import-and-export.md, "Blender".
"""
import argparse
import collections
import contextlib
import csv
import fractions
import math
import os
import re
import shlex
import shutil
import struct
import subprocess
import sys
import tempfile
import textwrap
import traceback
import xml.etree.ElementTree

import bpy
import mathutils

bl_info = {
    "name": "inbetween",
    "description": "Motions for camera rigs: export, check, import of plans and takes, armatures of rigs",
    "author": "the inbetween authors",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "3D view > Sidebar > inbetween",
    "category": "Animation",
}


class Refusal(Exception):
    """Something is wrong with what the user gave. The text is one line: what it is, and what to do."""


# --- numbers, units and names ----------------------------------------------------------------------------------------

# What one of each unit is in metres or in degrees. The words are those of `inbetween import`.
METRES = {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254, "ft": 0.3048}
DEGREES = {"deg": 1.0, "rad": math.degrees(1.0), "turn": 360.0}
ROTATION_ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
# A column of a file: its name, and its unit as a word, or None.
Column = collections.namedtuple("Column", "name unit")
# How a channel of Blender is called, and "m", "mm" or "deg".
Channel = collections.namedtuple("Channel", "name unit")
MAX_RATE_TERM = 1_000_000  # of the numerator and the denominator, as in inbetween
MAX_RATE = 1_000


def frame_rate(scene):
    """The rate of the scene as an exact fraction: 24 with a base of 1.001 is 24000/1001.

    Blender keeps the base in single precision, so the simplest fraction that rounds to it is the one that was meant.
    """
    base = scene.render.fps_base
    exact = fractions.Fraction(base)
    for limit in (1, 10, 100, 1_000, 10_000, 100_000):
        simple = exact.limit_denominator(limit)
        if struct.pack("f", simple) == struct.pack("f", base):
            exact = simple
            break
    rate = fractions.Fraction(scene.render.fps) / exact
    if rate > MAX_RATE or max(rate.numerator, rate.denominator) > MAX_RATE_TERM:
        raise Refusal(f"{scene.render.fps} / {base:.9g} frames a second is no rate of inbetween, which has fractions "
                      f"up to {MAX_RATE} of whole numbers up to {MAX_RATE_TERM}; choose one of Blender's list")
    return rate


def metres_per_unit(scene):
    """How long a unit of the scene is; one metre where the scene has no unit system, as in Blender's exporters."""
    settings = scene.unit_settings
    return 1.0 if settings.system == "NONE" else settings.scale_length


def number_word(value):
    """A number of a CSV file: nanometres and billionths of a degree, more than Blender's single precision holds."""
    if not math.isfinite(value):
        raise Refusal("a position is not a finite number; look for a driver or a constraint that fails")
    word = f"{value:.9f}"
    return word[1:] if float(word) == 0 and word.startswith("-") else word


def nearest_turn(angle, previous, whole=360.0):
    """The angle plus whole turns that is nearest to the previous one."""
    return angle + whole * round((previous - angle) / whole)


def split_name(header):
    """A column "pan (deg)" or "pan [deg]": its name and its unit; a word that is no unit belongs to the name."""
    match = re.fullmatch(r"(.*\S)\s*(?:\[([^\[\]]+)\]|\(([^()]+)\))", header.strip())
    word = match and (match.group(2) or match.group(3)).strip()
    if match and (word in METRES or word in DEGREES):
        return Column(match.group(1).strip(), word)
    return Column(header.strip(), None)


class AxisMap:
    """`--axis COLUMN=AXIS`, as `inbetween import` and `export` have it: a channel of Blender and an axis of the rig.

    `x=-slide` is the axis that goes the other way, `y=-` a channel that is of none.
    """

    def __init__(self, words):
        self.words = list(words)
        self.axes = {}  # by channel: the axis, or None; and whether it is reversed
        for word in self.words:
            channel, equals, axis = word.rpartition("=")
            if not equals or not channel.strip() or not axis.strip():
                raise Refusal(f'"{word}" is no CHANNEL=AXIS; write x=slide, x=-slide where it goes the other way')
            channel, axis = channel.strip(), axis.strip()
            if channel in self.axes:
                raise Refusal(f"the channel {channel} has two axes; give it one")
            is_reversed = axis.startswith("-")
            axis = axis[1:].strip() if is_reversed else axis
            self.axes[channel] = (axis or None, is_reversed)

    def options(self):
        """The same as options of a command of inbetween."""
        return [part for word in self.words for part in ("--axis", word)]

    def axis_of(self, channel):
        """The axis of a channel and the sign: that of its own name where nobody has said another."""
        axis, is_reversed = self.axes.get(channel, (channel, False))
        return axis, -1.0 if is_reversed else 1.0

    def refuse_unknown(self, channels):
        """Every channel that is named exists."""
        known = [channel.name for channel in channels]
        for channel in self.axes:
            if channel not in known:
                raise Refusal(f'there is no channel "{channel}"; here they are {", ".join(known)}')


# --- directions ------------------------------------------------------------------------------------------------------

# From Blender's world, with z up, to one with y up: (x, y, z) becomes (x, z, -y).
Y_UP = mathutils.Matrix(((1, 0, 0), (0, 0, 1), (0, -1, 0)))
Z_UP = mathutils.Matrix.Identity(3)
# A camera of Blender looks along its -z with y up; the tip of a rig looks along its x with z up. The columns are the
# axes of the camera in the frame of the tip.
CAMERA_IN_TIP = mathutils.Matrix(((0, 0, -1), (-1, 0, 0), (0, 1, 0)))
# Where the tangent of tilt is above 57, pan and roll turn about nearly the same line.
STEEP_TILT_DEG = 89.0


def world_of(up):
    """The matrix that takes Blender's world to one in which "y" or "z" is up."""
    return Y_UP if up == "y" else Z_UP


def pure_rotation(matrix, name):
    """The rotation in a matrix, without its scale. A mirrored or sheared object has none."""
    columns = [mathutils.Vector(column) for column in matrix.to_3x3().col]
    if min(column.length for column in columns) < 1e-9:
        raise Refusal(f"{name} has a scale of 0, so it has no direction; give it another scale")
    rotation = mathutils.Matrix([column.normalized() for column in columns]).transposed()
    skew = max(abs(rotation.col[i].dot(rotation.col[(i + 1) % 3])) for i in range(3))
    if skew > 1e-4 or rotation.determinant() < 0:
        raise Refusal(f"{name} is sheared or mirrored, so it has no direction; apply its scale and that of its parents")
    return rotation


# --- what moves: an object or a camera -------------------------------------------------------------------------------


class LensChannel:
    """A number of a camera's lens that may be animated."""

    def __init__(self, name, unit, path, is_length):
        self.name, self.unit, self.path, self.is_length = name, unit, path, is_length

    def owner(self, camera):
        """What has the property: the camera or a part of it."""
        return camera.dof if self.path.startswith("dof.") else camera

    def read(self, camera, metres):
        value = getattr(self.owner(camera), self.path.rpartition(".")[2])
        return value * metres if self.is_length else value

    def write(self, camera, value, metres):
        setattr(self.owner(camera), self.path.rpartition(".")[2], value / metres if self.is_length else value)


LENS_CHANNELS = (LensChannel("focal_length", "mm", "lens", False),
                 LensChannel("focus_distance", "m", "dof.focus_distance", True))


class ObjectMotion:
    """An object or a camera in the world.

    Channels: x, y, z in metres; pan, tilt, roll (`angles` is "head") or rx, ry, rz (`angles` is an order such as
    "XYZ") in degrees; of a camera focal_length in mm and focus_distance in metres.
    """

    def __init__(self, scene, obj, up, angles):
        self.scene, self.obj, self.up = scene, obj, world_of(up)
        self.metres = metres_per_unit(scene)
        is_camera = obj.type == "CAMERA"
        self.angles = ("head" if is_camera else "XYZ") if angles == "auto" else angles
        self.turned = CAMERA_IN_TIP if is_camera and self.angles == "head" else mathutils.Matrix.Identity(3)
        names = ("pan", "tilt", "roll") if self.angles == "head" else ("rx", "ry", "rz")
        self.channels = [Channel(name, "m") for name in "xyz"] + [Channel(name, "deg") for name in names]
        self.lens = LENS_CHANNELS if is_camera else ()
        self.channels += [Channel(lens.name, lens.unit) for lens in self.lens]
        self.previous = None

    def angles_of(self, rotation):
        """The three angles in degrees; each goes on from the ones before without a jump."""
        order = "XYZ" if self.angles == "head" else self.angles
        # About the world's up, a head of pan, tilt and roll is the same whichever coordinate points there.
        is_head = self.angles == "head"
        turned = rotation @ self.turned.transposed() if is_head else self.up @ rotation @ self.up.transposed()
        euler = turned.to_euler(order, self.previous) if self.previous else turned.to_euler(order)
        self.previous = euler.copy()
        x, y, z = (math.degrees(angle) for angle in euler)
        return (z, -y, x) if self.angles == "head" else (x, y, z)

    def rotation_of(self, angles):
        """The rotation in Blender's world that has these three angles."""
        if self.angles == "head":
            pan, tilt, roll = (math.radians(angle) for angle in angles)
            return mathutils.Euler((roll, -tilt, pan), "XYZ").to_matrix() @ self.turned
        euler = mathutils.Euler([math.radians(angle) for angle in angles], self.angles)
        return self.up.transposed() @ euler.to_matrix() @ self.up

    def sample(self, depsgraph):
        """The value of each channel as everything is now, constraints and parents included."""
        seen = self.obj.evaluated_get(depsgraph)
        place = self.up @ seen.matrix_world.translation
        angles = self.angles_of(pure_rotation(seen.matrix_world, self.obj.name))
        values = [coordinate * self.metres for coordinate in place] + list(angles)
        return values + [lens.read(seen.data, self.metres) for lens in self.lens]

    def left_out(self, rows):
        """Channels that need no column: a lens that does not change."""
        first = len(self.channels) - len(self.lens)
        return [i for i in range(first, len(self.channels)) if all(row[i] == rows[0][i] for row in rows)]

    def refuse_to_be_posed(self, given):
        """What would move the object away from its keyframes is refused before anything is changed."""
        if any(not constraint.mute for constraint in self.obj.constraints):
            raise Refusal(f"{self.obj.name} has constraints that would move it away; mute or remove them")
        deltas = [*self.obj.delta_location, *self.obj.delta_rotation_euler]
        if any(deltas) or self.obj.rotation_mode == "AXIS_ANGLE":
            raise Refusal(f"{self.obj.name} has delta transforms or turns by axis and angle; "
                          "clear the deltas and choose an Euler order")
        refuse_tracks(self.obj)

    def pose(self, frame, values, given):
        """Sets keyframes at a frame. `given` are the indices of the channels that the file has."""
        rotation = self.rotation_of(values[3:6])
        place = self.up.transposed() @ mathutils.Vector(values[:3]) / self.metres
        if self.obj.parent:
            self.scene.frame_set(frame)
            held = self.obj.matrix_world @ self.obj.matrix_basis.inverted()
            local = held.inverted() @ (mathutils.Matrix.Translation(place) @ rotation.to_4x4())
            place, rotation = local.translation, pure_rotation(local, self.obj.name)
        if any(i < 3 for i in given) or self.obj.parent:
            self.obj.location = place
            self.obj.keyframe_insert("location", frame=frame)
        if any(3 <= i < 6 for i in given) or self.obj.parent:
            self.pose_rotation(frame, rotation)
        for i, lens in enumerate(self.lens, start=6):
            if i in given:
                lens.write(self.obj.data, values[i], self.metres)
                self.obj.data.keyframe_insert(lens.path, frame=frame)

    def pose_rotation(self, frame, rotation):
        """The rotation in the mode of the object, beside the one before."""
        if self.obj.rotation_mode == "QUATERNION":
            quaternion = rotation.to_quaternion()
            if quaternion.dot(self.obj.rotation_quaternion) < 0:
                quaternion.negate()
            self.obj.rotation_quaternion = quaternion
            self.obj.keyframe_insert("rotation_quaternion", frame=frame)
        else:
            self.obj.rotation_euler = rotation.to_euler(self.obj.rotation_mode, self.obj.rotation_euler)
            self.obj.keyframe_insert("rotation_euler", frame=frame)

    def animated(self, given):
        """What gets keyframes."""
        owners = [self.obj] if any(i < 6 for i in given) else []
        return owners + ([self.obj.data] if any(i >= 6 for i in given) else [])

    def facts(self, rows):
        """What the columns mean, a line each."""
        up = "y" if self.up is Y_UP else "z"
        if self.angles != "head":
            return [f"{up} is up; rx, ry, rz turn in the order {self.angles} about the axes of the world"]
        lines = [f"{up} is up; pan 0 looks along x, positive to the left; tilt is positive upward; "
                 "roll is positive clockwise, seen from behind"]
        steep = sum(abs(row[4]) > STEEP_TILT_DEG for row in rows)
        if steep:
            lines.append(f"warning: tilt is beyond {STEEP_TILT_DEG:g} degrees in {steep} rows, where pan and roll "
                         "turn about nearly the same line and may become fast")
        return lines


# --- what moves: an armature -----------------------------------------------------------------------------------------


class BoneChannel:
    """One rotation or one translation of a bone that is not locked."""

    def __init__(self, bone, index, is_slide, name):
        self.bone, self.index, self.is_slide, self.name = bone, index, is_slide, name
        self.is_alone = name == bone.name

    def driven_path(self):
        """The property of the bone that its keyframes are of."""
        return "location" if self.is_slide else "rotation_euler"


def bone_channels(pose_bone):
    """The channels that a bone is free to move in. One that has a single channel gives it its name, as a joint does."""
    turns = [i for i in range(3) if not pose_bone.lock_rotation[i]]
    slides = [] if pose_bone.bone.use_connect else [i for i in range(3) if not pose_bone.lock_location[i]]
    if len(turns) + len(slides) == 1:
        return [BoneChannel(pose_bone, (turns + slides)[0], bool(slides), pose_bone.name)]
    return [BoneChannel(pose_bone, i, False, f"{pose_bone.name}.r{'xyz'[i]}") for i in turns] + \
        [BoneChannel(pose_bone, i, True, f"{pose_bone.name}.{'xyz'[i]}") for i in slides]


class ArmatureMotion:
    """The joints of an armature: a channel for each rotation (degrees) or translation (mm) that is not locked.

    Values are those of the bone against its rest pose, in its own axes, constraints included.
    """

    MILLIMETRES = 1000.0
    # A joint turns about one axis; more than this about another is no joint. Single precision gives less.
    MAX_SWING_RAD = 1e-3
    # What the pose of a bone that nobody moves is away from its rest, by single precision: far less than this.
    STILL = {"mm": 0.01, "deg": 0.001}

    def __init__(self, scene, obj):
        self.scene, self.obj = scene, obj
        self.scale = metres_per_unit(scene) * obj.matrix_world.median_scale * self.MILLIMETRES
        self.bones = [(bone, bone_channels(bone)) for bone in obj.pose.bones]
        self.parts = [channel for _, channels in self.bones for channel in channels]
        self.channels = [Channel(part.name, "mm" if part.is_slide else "deg") for part in self.parts]
        self.previous = {}
        if not self.parts:
            raise Refusal(f"every bone of {obj.name} is locked; unlock the rotations that are joints")

    def sample(self, depsgraph):
        """The value of each channel as everything is now."""
        seen = self.obj.evaluated_get(depsgraph)
        values = []
        for bone, channels in self.bones:
            if channels:
                values += self.sample_bone(seen, seen.pose.bones[bone.name], channels)
        return values

    def sample_bone(self, seen, bone, channels):
        local = seen.convert_space(pose_bone=bone, matrix=bone.matrix, from_space="POSE", to_space="LOCAL")
        if channels[0].is_alone:
            part = channels[0]
            if part.is_slide:
                return [local.translation[part.index] * self.scale]
            return [self.twist(bone, local, part.index)]
        order = bone.rotation_mode if bone.rotation_mode in ROTATION_ORDERS else "XYZ"
        before = self.previous.get(bone.name, bone.rotation_euler if order == bone.rotation_mode else None)
        turned = pure_rotation(local, bone.name)
        euler = turned.to_euler(order, before) if before else turned.to_euler(order)
        self.previous[bone.name] = euler.copy()
        return [local.translation[part.index] * self.scale if part.is_slide else math.degrees(euler[part.index])
                for part in channels]

    def twist(self, bone, local, index):
        """The angle of a joint that turns about one axis of its bone, with as many turns as it has made."""
        quaternion = pure_rotation(local, bone.name).to_quaternion()
        about = quaternion[1 + index]
        swing = math.sqrt(sum(quaternion[1 + i] ** 2 for i in range(3) if i != index))
        if 2 * swing > self.MAX_SWING_RAD:
            raise Refusal(f"the joint {bone.name} turns about another axis than its own by "
                          f"{math.degrees(2 * swing):.3f} degrees on frame {self.scene.frame_current}; "
                          "clear its other rotations, or unlock them")
        angle = math.degrees(2 * math.atan2(about, quaternion.w))
        before = self.previous.get(bone.name)
        if before is None:
            is_euler = bone.rotation_mode in ROTATION_ORDERS
            before = math.degrees(bone.rotation_euler[index]) if is_euler else 0.0
        self.previous[bone.name] = nearest_turn(angle, before)
        return self.previous[bone.name]

    def left_out(self, rows):
        """Channels that need no column: those of bones with several, where they stay at 0."""
        def is_still(i):
            return not self.parts[i].is_alone and all(abs(row[i]) < self.STILL[self.channels[i].unit] for row in rows)
        return [i for i in range(len(self.parts)) if is_still(i)]

    def refuse_to_be_posed(self, given):
        """What would not be where its keyframes are is refused before anything is changed."""
        for i in given:
            part = self.parts[i]
            if not part.is_slide and part.bone.rotation_mode not in ROTATION_ORDERS:
                raise Refusal(f"the bone {part.bone.name} does not turn by Euler angles; choose an Euler rotation mode")
        refuse_tracks(self.obj)

    def pose(self, frame, values, given):
        """Sets keyframes at a frame."""
        for i in given:
            part = self.parts[i]
            value = values[i] / self.scale if part.is_slide else math.radians(values[i])
            getattr(part.bone, part.driven_path())[part.index] = value
            part.bone.keyframe_insert(part.driven_path(), index=part.index, frame=frame)

    def animated(self, given):
        return [self.obj] if given else []

    def facts(self, rows):
        return ["a column is a bone: degrees that it turns, or mm that it slides, from its rest pose"]


def motion_of(scene, obj, up="z", angles="auto"):
    """The channels of an object, a camera or an armature."""
    return ArmatureMotion(scene, obj) if obj.type == "ARMATURE" else ObjectMotion(scene, obj, up, angles)


def refuse_tracks(obj):
    """NLA tracks would be mixed with the keyframes."""
    data = obj.animation_data
    if data and any(not track.mute for track in data.nla_tracks):
        raise Refusal(f"{obj.name} has NLA tracks that would move it as well; mute them")


# --- a motion goes out -----------------------------------------------------------------------------------------------


@contextlib.contextmanager
def frame_kept(scene):
    """The scene is on its frame again afterwards."""
    frame, subframe = scene.frame_current, scene.frame_subframe
    try:
        yield
    finally:
        scene.frame_set(frame, subframe=subframe)


def sampled(context, motion, first, last):
    """A row of values for each frame."""
    rows = []
    with frame_kept(motion.scene):
        for frame in range(first, last + 1):
            motion.scene.frame_set(frame)
            rows.append(motion.sample(context.evaluated_depsgraph_get()))
    return rows


def refuse_existing(path, over):
    if os.path.exists(path) and not over:
        raise Refusal(f"{path} is there already; say that it may be written over (--over), or choose another name")


def write_text(path, text):
    """Writes a file whole or not at all."""
    beside = f"{path}.{os.getpid()}.part"
    try:
        with open(beside, "w", encoding="utf-8", newline="") as file:
            file.write(text)
        os.replace(beside, path)
    except OSError as error:
        with contextlib.suppress(OSError):
            os.remove(beside)
        raise Refusal(f"{path} cannot be written: {error.strerror}") from error


def csv_text(motion, rows, first, columns):
    """The file that `inbetween import` reads."""
    lines = []
    header = ["frame"] + [f"{motion.channels[i].name} [{motion.channels[i].unit}]" for i in columns]
    lines.append(",".join('"' + name.replace('"', '""') + '"' if set(name) & set(',";\t') else name for name in header))
    for k, row in enumerate(rows):
        lines.append(",".join([str(first + k)] + [number_word(row[i]) for i in columns]))
    return "\n".join(lines) + "\n"


def import_words(path, rate, settings):
    """The command that makes a move of the file: it says all that the file does not hold."""
    # The rows of the move stand beside it under its name, so it has another one than the file.
    move = os.path.splitext(path)[0] + "_move.toml"
    words = ["inbetween", "import", path, "--rig", settings.rig or "RIG.toml", "--to", move]
    return words + ["--fps", str(rate), "--phase", settings.phase] + AxisMap(settings.axes).options()


def export_motion(context, settings):
    """Writes the motion of an object. Returns lines for the user; the last is the command that reads the file."""
    scene = context.scene
    rate = frame_rate(scene)
    first, last = settings.frames or (scene.frame_start, scene.frame_end)
    if last <= first:
        raise Refusal(f"frames {first}..{last} are no motion; it has two frames at least")
    refuse_existing(settings.path, settings.over)
    motion = motion_of(scene, settings.obj, settings.up, settings.angles)
    AxisMap(settings.axes).refuse_unknown(motion.channels)
    rows = sampled(context, motion, first, last)
    left_out = motion.left_out(rows)
    columns = [i for i in range(len(motion.channels)) if i not in left_out]
    if not columns:
        raise Refusal(f"nothing of {settings.obj.name} moves on frames {first}..{last}")
    write_text(settings.path, csv_text(motion, rows, first, columns))
    lines = [f"{settings.path}: {settings.obj.name} on frames {first}..{last}, {rate} a second, "
             f"{len(columns)} columns: {', '.join(motion.channels[i].name for i in columns)}"]
    if left_out:
        lines.append(f"left out, for they do not change: {', '.join(motion.channels[i].name for i in left_out)}")
    lines += motion.facts(rows)
    return lines + [shlex.join(import_words(settings.path, rate, settings))]


# --- a plan or a take comes in ---------------------------------------------------------------------------------------


class RowsFile:
    """What `inbetween plan --csv` or `inbetween export` wrote: a row for each frame."""

    def __init__(self, path):
        self.path = path
        try:
            with open(path, encoding="utf-8-sig", newline="") as file:
                lines = [line for line in csv.reader(file) if line]
        except (OSError, UnicodeDecodeError, csv.Error) as error:
            raise Refusal(f"{path} cannot be read: {getattr(error, 'strerror', None) or error}") from error
        if len(lines) < 3:
            raise Refusal(f"{path} has fewer than two rows; write it with inbetween plan --csv, or inbetween export")
        self.columns = [split_name(header) for header in lines[0]]
        names = [column.name for column in self.columns]
        if "frame" not in names:
            raise Refusal(f'{path} has no column "frame"; write a row for each frame (inbetween plan --per frame)')
        for name in names:
            if names.count(name) > 1:
                raise Refusal(f'{path} has two columns "{name}"; leave one out')
        self.rows = [self.numbers(i, line) for i, line in enumerate(lines[1:], start=2)]
        at = names.index("frame")
        self.frames = [row[at] for row in self.rows]
        for i, frame in enumerate(self.frames):
            if frame != int(frame) or frame != self.frames[0] + i:
                raise Refusal(f"{path}:{i + 2}: frame {frame:g} does not come next; frames are whole and ascend by one")
        self.seconds = [row[names.index("time_s")] for row in self.rows] if "time_s" in names else None

    def numbers(self, line, fields):
        if len(fields) != len(self.columns):
            raise Refusal(f"{self.path}:{line}: the row has {len(fields)} fields, and the first row "
                          f"{len(self.columns)}; write one for each column")
        try:
            values = [float(field) for field in fields]
        except ValueError:
            raise Refusal(f"{self.path}:{line}: a field is no number; write a decimal with a point") from None
        if not all(math.isfinite(value) for value in values):
            raise Refusal(f"{self.path}:{line}: a number is not finite; correct it")
        return values

    def refuse_other_rate(self, rate):
        """Times are those of the scene's rate, to a microsecond."""
        for frame, seconds in zip(self.frames, self.seconds or ()):
            expected = self.seconds[0] + (frame - self.frames[0]) / rate
            if abs(seconds - expected) > 1e-6:
                raise Refusal(f"{self.path}: frame {frame:g} is at {seconds:g} s, but the scene has {rate} frames a "
                              f"second; set the rate of the scene to that of the move")

    def values_of(self, name, unit):
        """A column in the unit of its channel; nothing where the file has none of this name."""
        found = [i for i, column in enumerate(self.columns) if column.name == name]
        if not found:
            return None
        word = self.columns[found[0]].unit
        sizes = DEGREES if unit == "deg" else METRES
        if word not in sizes:
            has = f"the unit {word}" if word else "no unit"
            raise Refusal(f'{self.path}: the column "{name}" has {has}; it is to be in {", ".join(sizes)}, such as '
                          f"{name} ({unit}): plan or export it with --rig or --unit")
        factor = sizes[word] / sizes[unit]
        return [row[found[0]] * factor for row in self.rows]


def columns_of(file, motion, axes):
    """The values of each channel that the file has, by the index of the channel, and the columns that are of none."""
    axes.refuse_unknown(motion.channels)
    found, used = {}, {"frame", "time_s"}
    for i, channel in enumerate(motion.channels):
        axis, sign = axes.axis_of(channel.name)
        values = file.values_of(axis, channel.unit) if axis else None
        if values is not None:
            found[i] = [sign * value for value in values]
            used.add(axis)
        elif channel.name in axes.axes and axis:
            raise Refusal(f'{file.path} has no column "{axis}"; it has '
                          f'{", ".join(column.name for column in file.columns)}')
    if not found:
        raise Refusal(f'{file.path} has no column for {motion.obj.name}; say which axis is which channel '
                      f'(--axis CHANNEL=AXIS): channels are {", ".join(channel.name for channel in motion.channels)}, '
                      f'columns {", ".join(column.name for column in file.columns if column.name not in used)}')
    return found, [column.name for column in file.columns if column.name not in used]


def curves_of(owner):
    """The curves of what has just got keyframes.

    Since Blender 4.4 an action has slots, and a camera and its object may share one action; its own curves are in the
    channel bag of its slot. Blender 5.0 has no others.
    """
    data = owner.animation_data
    slot = getattr(data, "action_slot", None)
    if slot is None:
        return data.action.fcurves
    from bpy_extras import anim_utils  # here, because Blender before 4.4 has no such function
    return anim_utils.action_get_channelbag_for_slot(data.action, slot).fcurves


def clear_for_keyframes(owners, over):
    """No earlier keyframes stay beside the new ones; the earlier action stays in the file, without a user."""
    taken = [owner for owner in owners if owner.animation_data and owner.animation_data.action]
    if taken and not over:
        raise Refusal(f"{taken[0].name} has keyframes already; say that they may be replaced (--over), "
                      "or choose another object")
    for owner in taken:
        owner.animation_data.action = None


def import_rows(context, settings):
    """Sets a keyframe for every row of a file on an object. Returns lines for the user."""
    scene = context.scene
    file = RowsFile(settings.path)
    rate = frame_rate(scene)
    file.refuse_other_rate(rate)
    motion = motion_of(scene, settings.obj, settings.up, settings.angles)
    found, others = columns_of(file, motion, AxisMap(settings.axes))
    given = sorted(found)
    motion.refuse_to_be_posed(given)
    stay = motion.sample(context.evaluated_depsgraph_get())
    owners = motion.animated(given)
    clear_for_keyframes(owners, settings.over)
    first = scene.frame_start if settings.at is None else settings.at
    with frame_kept(scene):
        for k, frame in enumerate(file.frames):
            values = [found[i][k] if i in found else stay[i] for i in range(len(stay))]
            motion.pose(first + int(frame), values, given)
    for owner in owners:
        for curve in curves_of(owner):
            for key in curve.keyframe_points:
                key.interpolation = "LINEAR"
            curve.update()
    last = first + int(file.frames[-1])
    lines = [f"{settings.obj.name} has {len(file.rows)} keyframes, on frames {first + int(file.frames[0])}..{last} at "
             f"{rate} a second: {', '.join(motion.channels[i].name for i in given)}"]
    if others:
        lines.append(f"columns that are of no channel: {', '.join(others)}")
    if last > scene.frame_end:
        lines.append(f"the scene ends before, on frame {scene.frame_end}")
    return lines


# --- a rig becomes an armature ---------------------------------------------------------------------------------------

JOINT_TYPES = ("fixed", "revolute", "continuous", "prismatic")
MAX_BONE_NAME_BYTES = 63  # of Blender


class RigJoint:
    """A joint of a URDF file, in metres and radians."""

    def __init__(self, element, path):
        self.path = path
        self.name = element.get("name") or ""
        self.type = element.get("type")
        if not self.name or len(self.name.encode()) > MAX_BONE_NAME_BYTES:
            raise Refusal(f'{path}: the joint "{self.name}" has no name that a bone may have, 1 to '
                          f"{MAX_BONE_NAME_BYTES} bytes; rename it")
        if self.type not in JOINT_TYPES:
            self.refuse(f'has the type "{self.type}"; the types are {", ".join(JOINT_TYPES)}')
        self.parent, self.child = (self.link_of(element, end) for end in ("parent", "child"))
        origin = element.find("origin")
        place = self.numbers(origin, "xyz", (0, 0, 0))
        roll, pitch, yaw = self.numbers(origin, "rpy", (0, 0, 0))
        # About the parent's x, then y, then z: the order that Blender calls XYZ.
        turned = mathutils.Euler((roll, pitch, yaw), "XYZ").to_matrix().to_4x4()
        self.origin = mathutils.Matrix.Translation(place) @ turned
        # A link that is fixed has no axis: its bone points where the link does, along x, as a camera looks.
        is_fixed = self.type == "fixed"
        self.axis = mathutils.Vector(self.numbers(None if is_fixed else element.find("axis"), "xyz", (1, 0, 0)))
        if self.axis.length == 0:
            self.refuse("has an axis without a direction; write xyz=\"0 0 1\", say")
        self.axis.normalize()
        limit = element.find("limit")
        has_limit = limit is not None and self.type in ("revolute", "prismatic")
        self.limit = tuple(self.number(limit, end, 0.0) for end in ("lower", "upper")) if has_limit else None
        if self.limit and self.limit[0] > self.limit[1]:
            self.refuse("has a lower limit above the upper one; exchange them")
        mimic = None if is_fixed else element.find("mimic")
        self.mimics = None if mimic is None else mimic.get("joint")
        self.multiplier, self.offset = self.number(mimic, "multiplier", 1.0), self.number(mimic, "offset", 0.0)

    def refuse(self, what):
        raise Refusal(f'{self.path}: the joint "{self.name}" {what}')

    def link_of(self, element, end):
        found = element.find(end)
        if found is None or not found.get("link"):
            self.refuse(f'has no <{end} link="...">; write the name of a link')
        return found.get("link")

    def numbers(self, element, attribute, default):
        text = None if element is None else element.get(attribute)
        if text is None:
            return default
        try:
            values = tuple(float(word) for word in text.split())
        except ValueError:
            values = ()
        if len(values) != len(default) or not all(math.isfinite(value) for value in values):
            self.refuse(f'has {attribute}="{text}"; write {len(default)} numbers')
        return values

    def number(self, element, attribute, default):
        return self.numbers(element, attribute, (default,))[0]


def read_rig(path):
    """The name of the robot of a URDF file, and its joints, each behind the one that carries it."""
    try:
        robot = xml.etree.ElementTree.parse(path).getroot()
    except (OSError, xml.etree.ElementTree.ParseError) as error:
        raise Refusal(f"{path} cannot be read as XML: {getattr(error, 'strerror', None) or error}") from error
    if robot.tag != "robot":
        raise Refusal(f"{path} does not begin with <robot>; is it a URDF file?")
    waiting = [RigJoint(element, path) for element in robot.findall("joint")]
    names = [joint.name for joint in waiting]
    children = [joint.child for joint in waiting]
    for joint in waiting:
        if names.count(joint.name) > 1:
            joint.refuse("is there twice; give each its own name")
        if children.count(joint.child) > 1:
            joint.refuse(f'holds the link "{joint.child}", which hangs on another joint too; a link has one joint')
        if joint.mimics is not None and joint.mimics not in names:
            joint.refuse(f'follows "{joint.mimics}", which is not there; correct the name')
    if not any(joint.type != "fixed" for joint in waiting):
        raise Refusal(f"{path} has no joint that moves; an armature needs one")
    roots = {link.get("name") for link in robot.findall("link")} | {joint.parent for joint in waiting}
    roots -= set(children)
    if len(roots) != 1:
        raise Refusal(f"{path} has {len(roots)} links that hang on nothing; there is to be one, the base")
    ordered, reached = [], set(roots)
    while waiting:
        ready = [joint for joint in waiting if joint.parent in reached]
        if not ready:
            waiting[0].refuse("is part of a circle; hang one of its links on the base")
        ordered += ready
        reached |= {joint.child for joint in ready}
        waiting = [joint for joint in waiting if joint.child not in reached]
    return robot.get("name") or "rig", ordered


def rest_frames(joints):
    """Where each joint is with all joints at 0: a matrix in metres in the frame of the base, by its child link."""
    frames = {}
    for joint in joints:
        frames[joint.child] = frames.get(joint.parent, mathutils.Matrix.Identity(4)) @ joint.origin
    return frames


def bone_length(joints, frames):
    """One length for all bones: long against the rounding of single precision, short against the rig."""
    places = [frames[joint.child].translation for joint in joints] + [mathutils.Vector()]
    reach = max((a - b).length for a in places for b in places)
    return 0.08 * reach if reach > 0 else 0.1


def build_armature(context, settings):
    """Builds an armature with one bone for each joint of a URDF file. Returns lines for the user."""
    name, joints = read_rig(settings.path)
    frames = rest_frames(joints)
    metres = metres_per_unit(context.scene)
    length = bone_length(joints, frames)
    if context.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    data = bpy.data.armatures.new(name)
    obj = bpy.data.objects.new(name, data)
    context.scene.collection.objects.link(obj)
    for other in context.selected_objects:
        other.select_set(False)
    obj.select_set(True)
    context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode="EDIT")
    by_link = {}
    for joint in joints:
        frame = frames[joint.child]
        bone = data.edit_bones.new(joint.name)
        # A bone points along the axis of its joint, so that the joint turns about the bone's own y.
        direction = frame.to_3x3() @ joint.axis
        bone.head = frame.translation / metres
        bone.tail = (frame.translation + direction * length) / metres
        bone.align_roll(frame.to_3x3() @ joint.axis.orthogonal() if joint.type != "fixed" else frame.to_3x3().col[2])
        bone.parent = by_link.get(joint.parent)
        by_link[joint.child] = bone
    bpy.ops.object.mode_set(mode="OBJECT")
    for joint in joints:
        set_up_bone(obj, joint, metres)
    for joint in joints:
        if joint.mimics is not None:
            follow(obj, joint, next(other for other in joints if other.name == joint.mimics), metres)
    add_beams(context, obj, joints, frames, length, metres)
    data.display_type = "OCTAHEDRAL"
    obj.show_in_front = True
    free = [joint.name for joint in joints if joint.type != "fixed" and joint.mimics is None]
    held = [joint.name for joint in joints if joint.name not in free]
    lines = [f"{obj.name}: an armature of {len(joints)} bones; joints that move: {', '.join(free)}"]
    if held:
        lines.append(f"fixed, or following another joint: {', '.join(held)}")
    return lines


def set_up_bone(obj, joint, metres):
    """The bone moves as its joint does, about or along its own y, and is locked otherwise."""
    bone = obj.pose.bones[joint.name]
    bone.rotation_mode = "YXZ"  # an order with y in the middle would lock where y is 90 degrees
    is_free = joint.type != "fixed" and joint.mimics is None
    slides = joint.type == "prismatic"
    bone.lock_location = (True, not (is_free and slides), True)
    bone.lock_rotation = (True, not is_free or slides, True)
    bone.lock_scale = (True, True, True)
    if not joint.limit or not is_free:
        return
    lower, upper = joint.limit
    if slides:
        limit = bone.constraints.new("LIMIT_LOCATION")
        limit.use_min_y = limit.use_max_y = True
        limit.min_y, limit.max_y = lower / metres, upper / metres
    elif lower >= -math.pi and upper <= math.pi:
        limit = bone.constraints.new("LIMIT_ROTATION")
        limit.use_limit_y = True
        limit.min_y, limit.max_y = lower, upper
    else:
        return  # a Limit Rotation sees no more than half a turn to either side
    limit.owner_space = "LOCAL"
    limit.use_transform_limit = True


def driven_by(joint):
    return ("location", 1) if joint.type == "prismatic" else ("rotation_euler", 1)


def follow(obj, joint, followed, metres):
    """A joint that mimics another is driven by it; the expression is one that Blender computes without Python."""
    path, index = driven_by(joint)
    driver = obj.pose.bones[joint.name].driver_add(path, index).driver
    driver.type = "SCRIPTED"
    variable = driver.variables.new()
    variable.name = "var"
    variable.type = "SINGLE_PROP"
    variable.targets[0].id = obj
    other_path, other_index = driven_by(followed)
    bone = bpy.utils.escape_identifier(followed.name)
    variable.targets[0].data_path = f'pose.bones["{bone}"].{other_path}[{other_index}]'
    size = 1 / metres if joint.type == "prismatic" else 1.0
    per = metres if followed.type == "prismatic" else 1.0
    driver.expression = f"var * {joint.multiplier * size * per!r} + {joint.offset * size!r}"


def add_beams(context, obj, joints, frames, length, metres):
    """A mesh of square beams from joint to joint, each carried by its bone, so that the rig can be seen."""
    vertices, faces, groups = [], [], []
    carrier = {joint.child: joint.name for joint in joints}
    half = length / 12
    for joint in joints:
        if joint.parent not in carrier:
            continue
        start, end = frames[joint.parent].translation, frames[joint.child].translation
        along = end - start
        if along.length < half:
            continue
        across = along.orthogonal().normalized() * half
        beside = along.cross(across).normalized() * half
        corners = [sx * across + sy * beside for sx, sy in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
        base = len(vertices)
        vertices += [(place + corner) / metres for place in (start, end) for corner in corners]
        faces += [[base + i for i in face] for face in ((3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5),
                                                        (2, 3, 7, 6), (3, 0, 4, 7))]
        groups.append((carrier[joint.parent], range(base, base + 8)))
    if not vertices:
        return
    mesh = bpy.data.meshes.new(f"{obj.name} beams")
    mesh.from_pydata(vertices, [], faces)
    beams = bpy.data.objects.new(mesh.name, mesh)
    context.scene.collection.objects.link(beams)
    beams.parent = obj
    for bone, corners in groups:
        group = beams.vertex_groups.get(bone) or beams.vertex_groups.new(name=bone)
        group.add(list(corners), 1.0, "REPLACE")
    beams.modifiers.new("Armature", "ARMATURE").object = obj


# --- does it fit the rig ---------------------------------------------------------------------------------------------


def program_of(settings):
    """The program inbetween: the one that is named, or the one on the path."""
    found = shutil.which(settings.program or "inbetween")
    if not found:
        raise Refusal(f'there is no program "{settings.program or "inbetween"}"; install inbetween, or say where it is')
    return found


def run_lines(words):
    """What a command of inbetween says, as lines, and its exit status."""
    try:
        ran = subprocess.run(words, capture_output=True, text=True, stdin=subprocess.DEVNULL, check=False)
    except OSError as error:
        raise Refusal(f"{words[0]} cannot be run: {error.strerror}") from error
    return [line.rstrip() for line in (ran.stdout + ran.stderr).splitlines() if line.strip()], ran.returncode


def check_motion(context, settings):
    """Holds the motion against the limits of the rig. Returns lines for the user and the exit status of the check."""
    program = program_of(settings)
    if not settings.rig or not os.path.isfile(settings.rig):
        raise Refusal(f'there is no rig file "{settings.rig}"; name the .toml file of the rig (--rig)')
    with tempfile.TemporaryDirectory(prefix="inbetween-") as folder:
        name = re.sub(r"[^\w.-]", "_", settings.obj.name)
        settings.path, settings.over = os.path.join(folder, f"{name}.csv"), True
        export_motion(context, settings)
        words = import_words(settings.path, frame_rate(context.scene), settings)
        lines, status = run_lines([program] + words[1:])
        if status == 0:
            lines, status = run_lines([program, "check", words[words.index("--to") + 1], "--rig", settings.rig])
        return [line.replace(folder + os.sep, "") for line in lines], status


# --- without a window ------------------------------------------------------------------------------------------------


class Settings:
    """What a button or a command line says of one operation."""

    def __init__(self, **values):
        self.obj, self.path, self.rig, self.program = None, "", "", ""
        self.axes, self.up, self.angles, self.phase = [], "z", "auto", "boundary"
        self.frames, self.at, self.over = None, None, False
        vars(self).update(values)


class LineParser(argparse.ArgumentParser):
    """A wrong command line is one line, as everything else that is wrong."""

    def error(self, message):
        raise Refusal(f"{message}; see --help")


def frame_range(text):
    match = re.fullmatch(r"(-?\d+)\.\.(-?\d+)", text)
    if not match:
        raise argparse.ArgumentTypeError(f'"{text}" is no range of frames; write 1..48')
    return int(match.group(1)), int(match.group(2))


def command_parser():
    parser = LineParser(prog="blender -b FILE.blend --python inbetween_blender.py --",
                        description="Motions between Blender and inbetween.")
    commands = parser.add_subparsers(dest="command", required=True, parser_class=LineParser)

    def add(name, text, *, path=None, to=None, moves=False):
        command = commands.add_parser(name, help=text, description=text)
        if path:
            command.add_argument("path", metavar=path)
        if to:
            command.add_argument("--to", dest="path", required=True, metavar=to, help="the file that is written")
        if moves:
            command.add_argument("--object", required=True, metavar="NAME", help="an object, a camera or an armature")
            command.add_argument("--axis", dest="axes", action="append", default=[], metavar="CHANNEL=AXIS",
                                 help="which axis of the rig a channel is; =-AXIS where it goes the other way")
            command.add_argument("--up", choices=("y", "z"), default="z", help="which coordinate points up in the file")
            command.add_argument("--angles", choices=("auto", "head") + ROTATION_ORDERS, default="auto",
                                 help="head: pan, tilt, roll, as cameras have; or an order of rx, ry, rz")
        return command

    def add_reach(command):
        command.add_argument("--frames", type=frame_range, metavar="FIRST..LAST", help="instead of those of the scene")
        command.add_argument("--phase", choices=("boundary", "centre"), default="boundary",
                             help="what the command of the import says of the rows")

    export = add("export", "write a motion for inbetween import", to="FILE.csv", moves=True)
    export.add_argument("--rig", default="", help="only for the command that is printed")
    export.add_argument("--over", action="store_true", help="write over a file that is there")
    add_reach(export)
    read = add("import", "set keyframes from inbetween plan --csv or inbetween export", path="FILE.csv", moves=True)
    read.add_argument("--at", type=int, metavar="FRAME", help="the frame of the scene that is frame 0; its first one")
    build = add("build", "build an armature of the joints of a URDF file", path="FILE.urdf")
    for command in (read, build):
        command.add_argument("--save", required=True, metavar="FILE.blend", help="the file that is written")
        command.add_argument("--over", action="store_true", help="replace keyframes, and a file that is there")
    check = add("check", "hold a motion against the limits of a rig", moves=True)
    check.add_argument("--rig", required=True, metavar="RIG.toml")
    check.add_argument("--program", default="", help="the program inbetween, where it is not on the path")
    add_reach(check)
    return parser


def run_command(context, arguments):
    """Runs a command line. Returns the exit status."""
    words = vars(command_parser().parse_args(arguments))
    command, save, name = words.pop("command"), words.pop("save", None), words.pop("object", None)
    settings = Settings(**words)
    if name is not None:
        settings.obj = context.scene.objects.get(name)
        if settings.obj is None:
            raise Refusal(f'the scene has no object "{name}"; it has '
                          f'{", ".join(obj.name for obj in context.scene.objects) or "none"}')
    if save:
        refuse_existing(save, settings.over)
    status = 0
    if command == "check":
        lines, status = check_motion(context, settings)
    else:
        lines = {"export": export_motion, "import": import_rows, "build": build_armature}[command](context, settings)
    if save:
        bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(save))
    print("\n".join(lines), flush=True)
    return status


def main(arguments):
    """The exit status: 0, 1 where something was wrong, or that of `inbetween check`."""
    try:
        return run_command(bpy.context, arguments)
    except Refusal as refusal:
        print(f"inbetween_blender: error: {refusal}", file=sys.stderr, flush=True)
    except Exception:  # Blender would print it, and end with status 0
        traceback.print_exc()
    return 1


# --- the panel -------------------------------------------------------------------------------------------------------

MAX_PANEL_LINES = 8
PANEL_LETTER_PX = 7.5  # of the panel's font, wide enough for a line of capitals and digits


FIELDS = {
    "export_path": bpy.props.StringProperty(
        name="To", subtype="FILE_PATH", default="//motion.csv", description="The CSV file that is written"),
    "rig": bpy.props.StringProperty(name="Rig", subtype="FILE_PATH", description="The .toml file of the rig"),
    "import_path": bpy.props.StringProperty(
        name="From", subtype="FILE_PATH", description="What inbetween plan --csv or inbetween export wrote"),
    "urdf": bpy.props.StringProperty(name="URDF", subtype="FILE_PATH", description="The geometry of the rig"),
    "program": bpy.props.StringProperty(
        name="Program", subtype="FILE_PATH", description="The program inbetween, where it is not on the path"),
    "axes": bpy.props.StringProperty(
        name="Axes", description="Which axis of the rig a channel is: x=slide, tilt=-nod"),
    "up": bpy.props.EnumProperty(
        name="Up", items=(("z", "z", "z points up in the file"), ("y", "y", "y points up in the file"))),
    "angles": bpy.props.EnumProperty(name="Angles", items=(
        ("auto", "Automatic", "Pan, tilt and roll of a camera, XYZ of other objects"),
        ("head", "Pan, tilt, roll", "As a remote head turns"),
        *((order, order, "rx, ry, rz in this order") for order in ROTATION_ORDERS))),
    "phase": bpy.props.EnumProperty(name="Phase", items=(
        ("boundary", "Boundary", "A row is frame k of the move, as in stop motion"),
        ("centre", "Centre", "A row is the middle of the exposure of its frame"))),
    "over": bpy.props.BoolProperty(name="Write over", description="Files and keyframes that are there"),
    "said": bpy.props.StringProperty(options={"HIDDEN"}),
}


class InbetweenFields(bpy.types.PropertyGroup):
    """What the panel asks for."""

    # Blender takes properties from annotations. Checkers of Python take an annotation for a type.
    __annotations__ = FIELDS


def axis_words(text):
    """The field "x=slide, pan=head pan" as words."""
    return [word.strip() for word in text.split(",") if word.strip()]


class PanelButton:
    """What the four buttons have in common: fields are read, lines are shown, a refusal is an error of Blender."""

    bl_options = {"REGISTER", "UNDO"}
    needs_object = True
    headline = 0  # which line says most

    @classmethod
    def poll(cls, context):
        return context.active_object is not None or not cls.needs_object

    def execute(self, context):
        fields = context.scene.inbetween
        settings = Settings(obj=context.active_object, rig=bpy.path.abspath(fields.rig), up=fields.up,
                            angles=fields.angles, phase=fields.phase, over=fields.over,
                            program=bpy.path.abspath(fields.program))
        try:
            settings.axes = axis_words(fields.axes)
            lines, status = self.run(context, fields, settings)
        except Refusal as refusal:
            self.show(context, [str(refusal)])
            self.report({"ERROR"}, str(refusal))
            return {"CANCELLED"}
        self.show(context, lines)
        self.report({"INFO"} if status == 0 else {"WARNING"}, lines[self.headline] if lines else "")
        return {"FINISHED"}

    def show(self, context, lines):
        """In the panel, and whole in the text "inbetween"."""
        context.scene.inbetween.said = "\n".join(lines)
        text = bpy.data.texts.get("inbetween") or bpy.data.texts.new("inbetween")
        text.from_string("\n".join(lines) + "\n")

    def needed(self, path, what):
        """A path that the user has given."""
        if not path:
            raise Refusal(f"no file is named; fill in {what}")
        if path.startswith("//") and not bpy.data.filepath:
            raise Refusal(f"{path} is beside the .blend file, which is not saved yet; save it, or choose a folder")
        return bpy.path.abspath(path)


class ExportMotion(PanelButton, bpy.types.Operator):
    """Writes the motion of the active object for inbetween import, and copies that command"""

    bl_idname = "inbetween.export_motion"
    bl_label = "Export motion"

    def run(self, context, fields, settings):
        settings.path = self.needed(fields.export_path, "To")
        lines = export_motion(context, settings)
        if not bpy.app.background:
            context.window_manager.clipboard = lines[-1]
        return lines, 0


class CheckMotion(PanelButton, bpy.types.Operator):
    """Holds the motion of the active object against the limits of the rig"""

    bl_idname = "inbetween.check_motion"
    bl_label = "Check"
    headline = -1  # the verdict

    def run(self, context, fields, settings):
        settings.rig = self.needed(fields.rig, "Rig")
        return check_motion(context, settings)


class ImportRows(PanelButton, bpy.types.Operator):
    """Sets keyframes on the active object from a plan or a take"""

    bl_idname = "inbetween.import_rows"
    bl_label = "Import plan or take"

    def run(self, context, fields, settings):
        settings.path = self.needed(fields.import_path, "From")
        return import_rows(context, settings), 0


class BuildArmature(PanelButton, bpy.types.Operator):
    """Builds an armature with a bone for each joint of a URDF file"""

    bl_idname = "inbetween.build_armature"
    bl_label = "Build armature"
    needs_object = False

    def run(self, context, fields, settings):
        settings.path = self.needed(fields.urdf, "URDF")
        return build_armature(context, settings), 0


class InbetweenPanel(bpy.types.Panel):
    """The tab in the sidebar of a 3D view"""

    bl_idname = "VIEW3D_PT_inbetween"
    bl_label = "inbetween"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "inbetween"

    def draw(self, context):
        fields, layout = context.scene.inbetween, self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        obj = context.active_object
        layout.label(text=obj.name if obj else "No object is active", icon="OBJECT_DATA")
        for name in ("axes", "up", "angles", "over"):
            layout.prop(fields, name)
        for operator, icon, names in ((ExportMotion, "EXPORT", ("export_path", "phase")),
                                      (CheckMotion, "CHECKMARK", ("rig", "program")),
                                      (ImportRows, "IMPORT", ("import_path",)),
                                      (BuildArmature, "ARMATURE_DATA", ("urdf",))):
            box = layout.box()
            for name in names:
                box.prop(fields, name)
            box.operator(operator.bl_idname, icon=icon)
        self.draw_said(context, fields.said.splitlines())

    def draw_said(self, context, lines):
        """The last lines, which have the verdict of a check, as wide as the panel is."""
        if not lines:
            return
        width = context.region.width / context.preferences.system.ui_scale / PANEL_LETTER_PX
        shown = []
        for line in reversed(lines):
            wrapped = textwrap.wrap(line.strip(), max(20, int(width)))
            if shown and len(shown) + len(wrapped) > MAX_PANEL_LINES:
                break
            shown = wrapped + shown
            lines = lines[:-1]
        column = self.layout.column()
        column.scale_y = 0.7
        for part in shown:
            column.label(text=part)
        if lines:
            column.label(text='More in text "inbetween"', icon="TEXT")


CLASSES = (InbetweenFields, ExportMotion, CheckMotion, ImportRows, BuildArmature, InbetweenPanel)


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.Scene.inbetween = bpy.props.PointerProperty(type=InbetweenFields)


def unregister():
    del bpy.types.Scene.inbetween
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)


if __name__ == "__main__":
    if "--" in sys.argv:
        sys.exit(main(sys.argv[sys.argv.index("--") + 1:]))
    register()
