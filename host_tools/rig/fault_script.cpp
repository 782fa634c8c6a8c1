#include "host_tools/rig/fault_script.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <variant>

#include "host_tools/rig_model/rig_motors.hpp"
#include "host_tools/text/toml_source.hpp"
#include "host_tools/text/toml_value.hpp"
#include "sim/cia402_objects.hpp"

namespace inbetween {
namespace {

using Kind = DriveTrouble::Kind;

constexpr std::array<std::string_view, 1> script_fields = {"fault"};
constexpr std::array<std::string_view, 16> fault_fields = {
    "axis", "what", "at",           "after_motion", "for", "count", "direction", "code",
    "to",   "mode", "frames_per_s", "object",       "sub", "value", "speed",     "ratio"};

/// A fault by its word, and which fields it has besides axis and what.
struct FaultKind {
  std::string_view word;
  Kind kind;
  bool has_time = true;    ///< at or after_motion; without, the drive is like that
  bool lasts = false;      ///< for
  bool counts = false;     ///< count, instead of for
  bool of_object = false;  ///< object and sub
  bool of_cia402 = false;  ///< other drives cannot have it
  std::string_view own{};  ///< the field that it has alone
};

constexpr std::array fault_kinds{
    FaultKind{
        .word = "lose-frames", .kind = Kind::lose_sent, .lasts = true, .counts = true, .own = "direction"},
    FaultKind{.word = "short-frames", .kind = Kind::shorten, .lasts = true, .counts = true},
    FaultKind{.word = "duplicate-frames",
              .kind = Kind::duplicate,
              .lasts = true,
              .counts = true,
              .of_cia402 = true},
    FaultKind{.word = "lose-heartbeat", .kind = Kind::lose_heartbeat, .lasts = true},
    FaultKind{.word = "emergency", .kind = Kind::emergency, .lasts = true, .own = "code"},
    FaultKind{.word = "stick", .kind = Kind::stick, .lasts = true},
    FaultKind{.word = "run-away", .kind = Kind::run_away, .lasts = true, .own = "speed"},
    FaultKind{.word = "blind", .kind = Kind::blind, .lasts = true, .of_cia402 = true},
    FaultKind{.word = "other-scale", .kind = Kind::other_scale, .has_time = false, .own = "ratio"},
    FaultKind{.word = "reboot", .kind = Kind::reboot},
    FaultKind{.word = "move-by-hand", .kind = Kind::move_by_hand, .own = "to"},
    FaultKind{.word = "ignore-target", .kind = Kind::ignore_target, .lasts = true},
    FaultKind{
        .word = "wrong-mode", .kind = Kind::wrong_mode, .lasts = true, .of_cia402 = true, .own = "mode"},
    FaultKind{.word = "foreign-sender", .kind = Kind::foreign_sender},
    FaultKind{.word = "flood", .kind = Kind::flood, .lasts = true, .own = "frames_per_s"},
    FaultKind{.word = "switched-off", .kind = Kind::switched_off},
    FaultKind{.word = "stay-on", .kind = Kind::stay_on, .lasts = true},
    FaultKind{.word = "no-home", .kind = Kind::no_home, .lasts = true, .of_cia402 = true},
    FaultKind{.word = "homing-error", .kind = Kind::homing_error, .lasts = true, .of_cia402 = true},
    FaultKind{.word = "no-window", .kind = Kind::no_window, .has_time = false, .of_cia402 = true},
    FaultKind{.word = "no-watchdog", .kind = Kind::no_watchdog, .has_time = false},
    FaultKind{.word = "no-object",
              .kind = Kind::no_object,
              .has_time = false,
              .of_object = true,
              .of_cia402 = true},
    FaultKind{.word = "fixed-object",
              .kind = Kind::fixed_object,
              .has_time = false,
              .of_object = true,
              .of_cia402 = true,
              .own = "value"},
    FaultKind{.word = "silent-object",
              .kind = Kind::silent_object,
              .has_time = false,
              .of_object = true,
              .of_cia402 = true},
};

const FaultKind& read_kind(const TomlTable& table) {
  std::array<std::string_view, fault_kinds.size()> words;
  std::ranges::transform(fault_kinds, words.begin(), &FaultKind::word);
  return fault_kinds.at(table.required("what", R"(what = "lose-frames", say)").choice(words));
}

/// A field that a fault does not have is refused: its author would wait for something that never happens.
void refuse_foreign_fields(const TomlTable& table, const FaultKind& kind) {
  const auto refuse = [&](std::string_view field, bool belongs) {
    const auto value = table.optional(field);
    if (belongs || !value) return;
    value->refuse(fmt::format("does not belong to what = \"{}\"; leave it out", kind.word));
  };
  refuse("at", kind.has_time);
  refuse("after_motion", kind.has_time);
  refuse("for", kind.lasts);
  refuse("count", kind.counts);
  refuse("object", kind.of_object);
  refuse("sub", kind.of_object);
  for (const std::string_view own :
       {"direction", "code", "to", "mode", "frames_per_s", "value", "speed", "ratio"}) {
    refuse(own, kind.own == own);
  }
}

std::size_t read_fault_axis(const TomlTable& table, const FaultKind& kind, const RigFile& rig) {
  const TomlValue value = table.required("axis", "the name of an axis of the rig");
  const std::string name = value.text();
  const auto axis = std::ranges::find(rig.axes, name, &RigAxis::name);
  if (axis == rig.axes.end()) {
    std::vector<std::string> names;
    for (const RigAxis& known : rig.axes) names.push_back(in_quotes(known.name));
    value.refuse(fmt::format("is {}, which the rig does not have; its axes are {}", in_quotes(name),
                             comma_separated(names)));
  }
  const bool is_cia402 = std::holds_alternative<Cia402Drive>(axis->drive);
  if (!is_cia402 && (kind.of_cia402 || !turns_per_unit_of(axis->drive))) {
    value.refuse(
        fmt::format("is {}, whose drive is not simulated with this fault; write an axis with a {} drive",
                    in_quotes(name), kind.of_cia402 ? "CiA 402" : "CAN"));
  }
  return static_cast<std::size_t>(axis - rig.axes.begin());
}

std::int64_t ns_of(double seconds) {
  return std::llround(seconds * 1e9);
}

void read_time(const TomlTable& table, ScriptedFault& fault) {
  const auto at = table.optional("at");
  const auto after_motion = table.optional("after_motion");
  if (at && after_motion) after_motion->refuse("is there beside at; write one of the two");
  if (after_motion) {
    fault.is_after_motion = true;
    fault.trouble.at_ns = ns_of(after_motion->number(0, max_fault_seconds));
    return;
  }
  const TomlValue value = table.required("at", "after_motion = 2.0 (seconds), or at = 0 (from power-on)");
  fault.trouble.at_ns = ns_of(value.number(0, max_fault_seconds));
}

void read_extent(const TomlTable& table, ScriptedFault& fault) {
  const auto seconds = table.optional("for");
  const auto count = table.optional("count");
  if (seconds && count) count->refuse("is there beside for; write one of the two");
  if (seconds) {
    fault.trouble.for_ns = ns_of(seconds->number(0, max_fault_seconds));
    if (fault.trouble.for_ns == 0) seconds->refuse("is 0; write how many seconds it lasts, or leave it out");
  }
  if (count) fault.trouble.frames = static_cast<std::int32_t>(count->integer(1, 1'000'000));
}

/// In units of the drive.
double read_place(const TomlValue& value, const RigAxis& axis) {
  if (const auto turns_per_unit = turns_per_unit_of(axis.drive)) {
    return value.number(-max_turns, max_turns) * *turns_per_unit;
  }
  const double counts = std::round(value.number() * std::get<Cia402Drive>(axis.drive).counts_per_unit);
  const double max = std::numeric_limits<std::int32_t>::max();
  if (std::fabs(counts) > max) {
    value.refuse(
        fmt::format("is {:.15g} counts of the drive; write a position within {:.15g} counts", counts, max));
  }
  return counts;
}

/// An object that the simulated drive has. `value` must fit into it.
void read_object(const TomlTable& table, const RigAxis& axis, DriveTrouble& trouble) {
  const TomlValue index = table.required("object", "the index of the object, object = 0x605E");
  trouble.object.index = static_cast<std::uint16_t>(index.integer(0x1000, 0xFFFF));
  if (const auto sub = table.optional("sub"))
    trouble.object.sub = static_cast<std::uint8_t>(sub->integer(0, 255));
  const ObjectDictionary objects =
      factory_objects(can::NodeId::make(std::get<Cia402Drive>(axis.drive).node).value());
  const ObjectDictionary::Object* const object = objects.find(trouble.object);
  if (object == nullptr) {
    index.refuse(
        fmt::format("is {:04X}h, which the simulated drive does not have with sub {}; write one that it has",
                    trouble.object.index, trouble.object.sub));
  }
  if (trouble.kind != Kind::fixed_object) return;
  const std::int64_t max = (std::int64_t{1} << (8 * object->size)) - 1;
  const std::int64_t value = table.required("value", "what it has, value = 0").integer(0, max);
  trouble.value = static_cast<std::int32_t>(static_cast<std::uint32_t>(value));
}

/// Of a drive that takes positions in another scale than it tells them: any other tells what it takes.
double read_ratio(const TomlValue& value, const RigAxis& axis) {
  if (!std::holds_alternative<CubemarsDrive>(axis.drive)) {
    value.refuse(
        fmt::format("needs an axis with a cubemars drive, whose positions have two scales, and {} has "
                    "none; leave it out",
                    in_quotes(axis.name)));
  }
  constexpr double max_ratio = 1000;
  return value.number(-max_ratio, max_ratio);
}

/// The largest error that the drive of an axis can tell.
std::int64_t max_error_of(const RigAxis& axis) {
  if (std::holds_alternative<Cia402Drive>(axis.drive)) return 0xFFFF;
  if (std::holds_alternative<MoteusDrive>(axis.drive)) return 127;
  return std::numeric_limits<std::int32_t>::max();
}

void read_own(const TomlTable& table, const FaultKind& kind, const RigFile& rig, ScriptedFault& fault) {
  DriveTrouble& trouble = fault.trouble;
  const auto whole = [&](const TomlValue& value, std::int64_t min, std::int64_t max) {
    trouble.value = static_cast<std::int32_t>(value.integer(min, max));
  };
  switch (kind.kind) {
    case Kind::lose_sent:
      if (table.required("direction", R"(direction = "from-drive" or "to-drive")")
              .choice({"from-drive", "to-drive"}) == 1) {
        trouble.kind = Kind::lose_heard;
      }
      return;
    case Kind::emergency:
      return whole(
          table.required("code", "the code of the EMCY, code = 0x2310, or the error of another drive"), 1,
          max_error_of(rig.axes[fault.axis]));
    case Kind::move_by_hand:
      trouble.kind = Kind::put_by_hand;
      trouble.place = read_place(table.required("to", "the position that it is moved to, to = 0.0"),
                                 rig.axes[fault.axis]);
      return;
    case Kind::run_away:
      trouble.place = read_place(table.required("speed", "how fast it runs, speed = 60.0 (unit/s)"),
                                 rig.axes[fault.axis]);
      return;
    case Kind::other_scale:
      trouble.place = read_ratio(table.required("ratio", "how far it goes for one unit, ratio = 1.25"),
                                 rig.axes[fault.axis]);
      return;
    case Kind::wrong_mode:
      return whole(table.required("mode", "the mode that the drive shows, mode = 1"), -128, 127);
    case Kind::no_object:
    case Kind::fixed_object:
    case Kind::silent_object:
      return read_object(table, rig.axes[fault.axis], trouble);
    case Kind::flood:
      return whole(table.required("frames_per_s", "frames_per_s = 5000, say"), 1, max_flood_per_s);
    default:
      return;
  }
}

ScriptedFault read_fault(const TomlValue& value, const RigFile& rig) {
  const TomlTable table(value.table(), "a fault", fault_fields);
  const FaultKind& kind = read_kind(table);
  refuse_foreign_fields(table, kind);
  ScriptedFault fault;
  fault.axis = read_fault_axis(table, kind, rig);
  fault.what = kind.word;
  fault.trouble.kind = kind.kind;
  if (kind.has_time) read_time(table, fault);
  read_extent(table, fault);
  read_own(table, kind, rig, fault);
  return fault;
}

}  // namespace

FaultScript parse_fault_script(std::string_view text, const std::string& file_name, const RigFile& of) {
  const RigFile rig = motors_of(of).rig;
  const toml::table root = parse_toml(text, file_name);
  if (root.empty()) throw InputError(place_of(root), "the file is empty; a script of faults has a [[fault]]");
  const TomlTable table(root, "a script of faults", script_fields);
  FaultScript script;
  script.path = file_name;
  for (const TomlValue& fault :
       table.required("fault", "a [[fault]] with its axis and what happens").tables(max_faults)) {
    script.faults.push_back(read_fault(fault, rig));
  }
  return script;
}

FaultScript read_fault_script(const std::filesystem::path& path, const RigFile& rig) {
  return parse_fault_script(read_text_file(path), path.string(), rig);
}

}  // namespace inbetween
