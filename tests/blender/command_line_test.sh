#!/usr/bin/env bash
# The script inside Blender without a window, as its head and docs/import-and-export.md show it: what it writes, what it
# refuses and how, and that a wrong command ends with status 1, where Blender by itself ends with 0.
#
#   command_line_test.sh ROOT PROGRAM
set -euo pipefail
# shellcheck source=tests/support/expect.sh
source "${BASH_SOURCE[0]%/*}/../support/expect.sh"
root=$1
program=$(realpath "$2")
scratch=$(mktemp --directory)
trap 'rm --recursive --force "$scratch"' EXIT
export BLENDER_USER_SCRIPTS=$scratch/scripts BLENDER_USER_CONFIG=$scratch/config
cd "$scratch"
script=$root/host_tools/exchange/blender/inbetween_blender.py

in_blender() { # in_blender FILE.blend ARGUMENT...: what the script says, and the status behind it
  local status=0 file=()
  [[ $1 == - ]] || file=("$1")
  blender --background --factory-startup "${file[@]}" --python "$script" -- "${@:2}" >out 2>err || status=$?
  cat err
  # What Blender says of itself.
  grep --invert-match --extended-regexp '^(Blender |Read blend:|Info: |Saved |$)' out || true
  printf 'status %d\n' "$status"
}

# --- a motion goes out ---
expect "an export says what it wrote, what its columns mean, and the command that reads it" \
  "camera.csv: Camera on frames 1..3, 24 a second, 6 columns: x, y, z, pan, tilt, roll
left out, for they do not change: focal_length, focus_distance
z is up; pan 0 looks along x, positive to the left; tilt is positive upward; roll is positive clockwise, seen from behind
inbetween import camera.csv --rig 'my rig.toml' --to camera_move.toml --fps 24 --phase boundary --axis x=slide --axis y=-
status 0" \
  "$(in_blender - export --object Camera --to camera.csv --frames 1..3 --rig 'my rig.toml' --axis x=slide --axis y=-)"
expect "a row for each frame" "frame,x [m],y [m],z [m],pan [deg],tilt [deg],roll [deg]
1
2
3" "$(sed '2,$s/,.*//' camera.csv)"
before=$(sha256sum camera.csv)
expect "nothing is written over unasked" \
  "inbetween_blender: error: camera.csv is there already; say that it may be written over (--over), or choose another name
status 1" "$(in_blender - export --object Camera --to camera.csv)"
expect "and it is not" "$before" "$(sha256sum camera.csv)"
expect "an object that is not there" \
  'inbetween_blender: error: the scene has no object "Kamera"; it has Cube, Light, Camera
status 1' "$(in_blender - export --object Kamera --to other.csv)"
expect "a wrong word on the command line" \
  'inbetween_blender: error: argument --frames: "1-3" is no range of frames; write 1..48; see --help
status 1' "$(in_blender - export --object Camera --to other.csv --frames 1-3)"
expect "a folder that is not there" \
  'inbetween_blender: error: nowhere/other.csv cannot be written: No such file or directory
status 1' "$(in_blender - export --object Camera --to nowhere/other.csv)"

# --- a rig, a plan on it, and a check ---
crane=$root/examples/crane
expect "an armature has a bone for each joint" \
  "crane: an armature of 9 bones; joints that move: track, swing, boom, pan, tilt, roll
fixed, or following another joint: stage, parallelogram, mount
status 0" "$(in_blender - build "$crane/crane.urdf" --save crane.blend)"
"$program" plan "$crane/over_the_table.toml" --rig "$crane/rig.toml" --csv plan.csv >/dev/null
expect "a plan becomes keyframes" \
  "crane has 289 keyframes, on frames 1..289 at 24 a second: track, swing, boom, pan, tilt, roll
columns that are of no channel: camera x, camera y, camera z
the scene ends before, on frame 250
status 0" "$(in_blender crane.blend import plan.csv --object crane --save played.blend)"
expect "which are not replaced unasked" \
  "inbetween_blender: error: crane has keyframes already; say that they may be replaced (--over), or choose another object
status 1" "$(in_blender played.blend import plan.csv --object crane --save again.blend)"
checked=$(in_blender played.blend check --object crane --rig "$crane/rig.toml" --program "$program" --frames 1..289)
expect "the plan that the rig can follow still fits after its way through Blender" 'status 0' "${checked##*$'\n'}"
expect "and the lines of the check are shown" 1 "$(grep --count 'swing' <<<"$checked" | sed 's/[1-9][0-9]*/1/')"
in_blender played.blend export --object crane --to crane.csv --frames 1..289 >/dev/null
"$program" import crane.csv --rig "$crane/rig.toml" --to crane_move.toml --fps 24 --phase boundary >/dev/null
"$program" plan crane_move.toml --rig "$crane/rig.toml" --csv back.csv >/dev/null
# Single precision may leave the last rows a last bit apart, and the move then has a post-roll behind its 289 rows.
expect "on every frame the positions are the same to a thousandth of a mm or degree" 0 \
  "$(paste --delimiters=, plan.csv <(head --lines=290 back.csv) | awk -F, 'NR > 1 { for (i = 3; i <= 8; i++) {
    off = $i - $(i + 11); if (off > 1e-3 || off < -1e-3) wrong++ } } END { print wrong + 0 }')"
sed 's/max_velocity = .*/max_velocity = 1.0/' "$crane/rig.toml" >slow.toml
cp "$crane/crane.urdf" .
checked=$(in_blender played.blend check --object crane --rig slow.toml --program "$program" --frames 1..289)
expect "a motion that the rig cannot follow ends as inbetween check does" 'status 3' "${checked##*$'\n'}"

# --- what is no rig ---
printf '<robot name="r"><link name="a"/><joint name="j" type="planar"/></robot>' >planar.urdf
expect "a joint of another type" \
  'inbetween_blender: error: planar.urdf: the joint "j" has the type "planar"; the types are fixed, revolute, continuous, prismatic
status 1' "$(in_blender - build planar.urdf --save planar.blend)"
expect "nothing was written" 'no' "$([[ -e planar.blend ]] && echo yes || echo no)"

all_was_as_expected 'the script inside Blender does what its command line says'
