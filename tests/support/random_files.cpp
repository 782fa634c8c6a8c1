#include "tests/support/random_files.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <initializer_list>
#include <map>
#include <vector>

#include "tests/support/places.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace {

class Writer {
 public:
  explicit Writer(std::mt19937& random) : random_(random) {}

  RandomFiles write() {
    switch (number(0, 4)) {
      case 0:
        kind_ = Kind::arm;
        files_.rig_folder = "examples/arm";
        break;
      case 1:
        kind_ = Kind::crane;
        files_.rig_folder = "examples/crane";
        break;
      case 2:
        break;  // no rig at all
      default:
        kind_ = Kind::plain;
        write_rig();
    }
    write_move();
    return files_;
  }

 private:
  enum class Kind { none, plain, arm, crane };

  int number(int least, int most) { return std::uniform_int_distribution<int>(least, most)(random_); }
  bool chance(double share) { return std::uniform_real_distribution<double>(0, 1)(random_) < share; }
  double real(double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random_);
  }
  template <class T>
  T one_of(std::initializer_list<T> all) {
    return all.begin()[number(0, static_cast<int>(all.size()) - 1)];
  }
  /// Few more often than many.
  int few(int most) { return chance(0.6) ? number(1, 3) : number(1, most); }
  void may(double share, const std::string& text) {
    if (chance(share)) files_.move += text + "\n";
  }

  void write_rig() {
    std::vector<AxisText> axes;
    int node = 0;
    for (const char* name : {"a", "b", "c", "d"}) {
      AxisText axis{.name = name,
                    .unit = one_of({"mm", "deg", "unit"}),
                    .min = one_of({-100.0, 0.0, -180.0}),
                    .max = one_of({100.0, 1.0, 720.0}),
                    .max_velocity = one_of({50.0, 5000.0}),
                    .max_acceleration = one_of({100.0, 1e6}),
                    .more = "unpowered = \"holds\"\nreference = \"drive\"\n",
                    .drive = cia402_text(++node, 100)};
      const auto add = [&](double share, const std::string& line) {
        if (chance(share)) axis.more += line + "\n";
      };
      add(0.4, fmt::format("max_jerk = {}", one_of({1000.0, 1e8})));
      add(0.2, "max_acceleration_step = 20");
      add(0.3, fmt::format("stop_acceleration = {}", one_of({1e6, 3e6})));
      add(0.2, "offset = 2.5");
      add(0.15, "backlash = { play = 0.05, take_up_s = 0.25, approach = \"positive\" }");
      if (chance(0.15)) {
        axis.more += fmt::format(
            "calibration = {{ unit = \"deg\", marks = [[{}, -60], [{}, 0], [{}, 70]], max_velocity = 1e6, "
            "max_acceleration = 1e7, "
            "stop_acceleration = 3e7 }}\n",
            axis.min, (axis.min + axis.max) / 2, axis.max);
      }
      axes.push_back(axis);
    }
    files_.rig =
        rig_text(axes, {.rate_hz = one_of({100, 250}), .more = "step_watch_us = 40\n" + bus_can0 + lines()});
  }
  static std::string lines() {
    return "[start_trigger]\nchip = \"gpio\"\nline = 6\n[output.lamp]\nchip = \"gpio\"\nline = 19\nidle = "
           "\"low\"\n";
  }

  void write_move() {
    frames_ = chance(0.3) ? number(1, 6) : number(1, 120);
    files_.move = fmt::format("name = \"random\"\nfps = {}\nframes = {}\n",
                              one_of<std::string>({"24", "\"24000/1001\"", "1", "120"}), frames_);
    may(kind_ == Kind::plain ? 0.1 : 0.01, "start = \"trigger\"");
    may(kind_ == Kind::plain ? 0.1 : 0.01, "clapper = { line = \"lamp\", width_ms = 5 }");
    std::vector<std::string> free = axes();
    const int tracks = chance(0.6) ? 1 : number(1, 3);
    for (int t = 0; t < tracks && !free.empty(); ++t) {
      const auto count = static_cast<std::size_t>(is_in_space(t) ? static_cast<int>(free.size())
                                                                 : number(1, static_cast<int>(free.size())));
      write_track({free.begin(), free.begin() + static_cast<std::ptrdiff_t>(count)}, is_in_space(t));
      free.erase(free.begin(), free.begin() + static_cast<std::ptrdiff_t>(count));
    }
    if (!chance(kind_ == Kind::plain || kind_ == Kind::none ? 0.1 : 0.01)) return;
    files_.move += fmt::format("[[cue]]\nline = \"lamp\"\n{}\nwidth_ms = 1\n",
                               one_of<std::string>({"every = 1", "frames = [0]", "every = 2\nphase = 0.25"}));
  }
  [[nodiscard]] std::vector<std::string> axes() const {
    if (kind_ == Kind::arm) return {"shoulder", "elbow"};
    if (kind_ == Kind::crane) return {"track", "swing", "boom", "pan", "tilt", "roll"};
    return {"a", "b", "c", "d"};
  }
  bool is_in_space(int track) {
    if (track == 0) wants_space_ = chance(0.6);
    return track == 0 && wants_space_ && (kind_ == Kind::arm || kind_ == Kind::crane);
  }

  void write_track(const std::vector<std::string>& axes, bool in_space) {
    track_axes_ = axes;
    std::vector<std::string> quoted;
    for (const std::string& axis : axes) quoted.push_back('"' + axis + '"');
    files_.move += fmt::format("[[track]]\naxes = [{}]\n", fmt::join(quoted, ", "));
    const int keys = few(7);
    const bool has_frames = chance(0.25);
    const bool is_aimed_by_track = in_space && kind_ == Kind::crane && chance(0.5);
    spline_ = one_of<std::string>({"smooth", "smooth", "catmull-rom", "tcb", "linear"});
    drawn_.clear();
    const bool is_of_plain_rig = kind_ == Kind::plain || kind_ == Kind::none;
    if (has_frames && is_of_plain_rig && spline_ == "smooth" && keys > 1) write_network(axes);
    if (spline_ != "smooth" || chance(0.3)) files_.move += "spline = \"" + spline_ + "\"\n";
    const bool may_keep_between = spline_ == "smooth" || spline_ == "catmull-rom";
    if (chance(0.2)) {
      files_.move += "closed = true\n";
      may(0.5, "periodic = true");
    }
    may(may_keep_between ? 0.25 : 0.02, fmt::format("overshoot = {}", chance(0.7) ? "false" : "true"));
    may(0.2, fmt::format("corners = \"{}\"", one_of<const char*>({"ease", "pass"})));
    if (has_frames) {
      files_.move += "timing = \"frames\"\n";
      may(0.8,
          fmt::format("kinetic = \"{}\"", one_of<const char*>({"linear", "curves", "pace", "monotone"})));
    } else {
      write_speed();
    }
    may(has_frames ? 0.1 : 0.3,
        fmt::format("rest = \"{}\"", one_of<const char*>({"both", "start", "end", "none"})));
    if (in_space) {
      files_.move += kind_ == Kind::arm ? "space = \"hand\"\nelbow = \"up\"\n" : "space = \"camera\"\n";
      if (is_aimed_by_track) files_.move += "aim = [0.0, 0.2, 0.9]\n";
    } else if (kind_ == Kind::arm || kind_ == Kind::crane) {
      may(0.4, kind_ == Kind::arm ? "distance = \"hand\"" : "distance = \"camera\"");
    } else {
      if (chance(0.15)) {
        files_.move += "wrap = 360\n";
      } else if (chance(0.15)) {
        std::vector<int> weights;
        for (std::size_t i = 0; i < axes.size(); ++i) weights.push_back(number(i == 0 ? 1 : 0, 3));
        files_.move += fmt::format("weights = [{}]\n", fmt::join(weights, ", "));
      }
    }
    if (spline_ == "linear") {
      may(has_frames ? 0.4 : 0.02, fmt::format("overlap = {}", one_of({0, 1, 2, 8})));
      may(has_frames || in_space ? 0.02 : 0.4, fmt::format("round = {}", one_of({0.0, 0.25, 4.0, 100.0})));
    }
    files_.move += "keys = [\n";
    for (int k = 0; k < keys; ++k) write_key(k, keys, axes.size(), has_frames, in_space, is_aimed_by_track);
    files_.move += "]\n";
  }

  /// Half of the time. The first axis is drawn, and sometimes the last. Keys leave them out, so that they
  /// meet their curves. The numbers are not of random_: other files stay what they have been.
  void write_network(const std::vector<std::string>& axes) {
    std::seed_seq seed(files_.move.begin(), files_.move.end());
    std::mt19937 random_of_network(seed);
    const auto real = [&](double least, double most) {
      return std::uniform_real_distribution<double>(least, most)(random_of_network);
    };
    const auto number = [&](int least, int most) {
      return std::uniform_int_distribution<int>(least, most)(random_of_network);
    };
    if (number(0, 1) == 0) return;
    files_.move += "network = true\n";
    drawn_.push_back(0);
    if (axes.size() > 1 && number(0, 1) == 0) drawn_.push_back(axes.size() - 1);
    std::vector<std::string> curves;
    for (const std::size_t d : drawn_) {
      std::string points = fmt::format("{{ frame = 0, at = {} }}", real(-30, 60));
      for (int frame = number(1, 20); frame < frames_; frame += number(1, 20)) {
        points += fmt::format(", {{ frame = {}, at = {} }}", frame, number(0, 2) == 0 ? 0.0 : real(-30, 60));
      }
      curves.push_back(
          fmt::format("{} = [{}, {{ frame = {}, at = {} }}]", axes[d], points, frames_, real(-30, 60)));
    }
    files_.move += fmt::format("drawn = {{ {} }}\n", fmt::join(curves, ", "));
    if (number(0, 2) > 0) return;
    std::vector<int> places{0};
    while (places.size() < axes.size()) places.push_back(places.back() + number(0, 2));
    files_.move += fmt::format("places = [{}]\n", fmt::join(places, ", "));
  }

  void write_speed() {
    const int values = chance(0.5) ? number(1, 4) : number(1, 24);
    std::vector<double> speed;
    for (int i = 0; i < values; ++i) speed.push_back(one_of({0.0, 1.0, 10.0, 100.0, real(0, 20)}));
    if (chance(0.3)) speed.back() = speed.front();
    files_.move += fmt::format("speed = [{}]\n", fmt::join(speed, ", "));
    may(0.25, "through = true");
    may(0.2, fmt::format("ease_in = {}", number(0, frames_)));
    may(0.2, fmt::format("ease_out = {}", number(0, frames_)));
  }

  void write_key(int k, int keys, std::size_t axes, bool has_frames, bool in_space, bool is_aimed_by_track) {
    std::vector<double> at;
    std::string more;
    if (in_space && kind_ == Kind::arm) {
      at = {real(0.2, 0.5), real(-0.2, 0.3), 0};
    } else if (in_space) {
      at = {real(2.4, 3.4), real(0.4, 1.4), real(0.6, 1.2)};
      if (!is_aimed_by_track) more += fmt::format(", aim = [0, {}, 1]", one_of({0.0, 0.3}));
      more += ", roll = 0";
    } else {
      for (std::size_t d = 0; d < axes; ++d) at.push_back(one_of({0.0, 1.0, 0.5, real(0, 60), real(-30, 0)}));
    }
    if (k > 0 && at.size() == last_at_.size() && chance(0.2)) at = last_at_;
    last_at_ = at;
    const auto add = [&](double share, const std::string& field) {
      if (chance(share)) more += ", " + field;
    };
    if (has_frames) {
      const int frame = keys == 1 ? 0 : k * frames_ / (keys - 1);
      more += fmt::format(", frame = {}", frame);
    } else {
      add(k == 0 ? 0.02 : 0.12,
          fmt::format("frame = {}{}", number(0, frames_), chance(0.3) ? ", break = true" : ""));
      add(0.01, "break = true");
      add(0.1, fmt::format("hold = {}", number(1, frames_)));
    }
    add(k == 0 || k == keys - 1 || has_frames ? 0.02 : 0.2, "ease = true");
    add(spline_ == "tcb" ? 0.3 : 0.005, fmt::format("tension = {}", one_of({-1.0, 0.3, 1.0})));
    add(spline_ == "tcb" ? 0.3 : 0.005, fmt::format("continuity = {}", one_of({-1.0, 1.0})));
    files_.move += fmt::format("  {{ at = {}{} }},\n", position_in_words(at), more);
  }
  [[nodiscard]] std::string position_in_words(const std::vector<double>& at) const {
    if (drawn_.empty()) return fmt::format("[{}]", fmt::join(at, ", "));
    std::vector<std::string> words;
    for (std::size_t d = 0; d < at.size(); ++d) {
      if (std::ranges::find(drawn_, d) == drawn_.end())
        words.push_back(fmt::format("{} = {}", track_axes_[d], at[d]));
    }
    return fmt::format("{{ {} }}", fmt::join(words, ", "));
  }

  std::mt19937& random_;
  Kind kind_ = Kind::none;
  RandomFiles files_;
  int frames_ = 0;
  bool wants_space_ = false;
  std::string spline_;
  std::vector<double> last_at_;
  std::vector<std::string> track_axes_;
  std::vector<std::size_t> drawn_;  ///< axes of the track, if it is a network
};

}  // namespace

RandomFiles random_files(std::mt19937& random) {
  return Writer(random).write();
}

std::optional<RigFile> rig_of(const RandomFiles& files) {
  if (!files.rig_folder.empty()) return read_rig_file(in_checkout(files.rig_folder + "/rig.toml"));
  if (!files.rig.empty()) return parse_rig(files.rig, "rig.toml");
  return std::nullopt;
}

std::shared_ptr<const Kinematics> joints_of(const RandomFiles& files, const std::optional<RigFile>& rig) {
  if (files.rig_folder.empty()) return nullptr;
  static std::map<std::string, std::shared_ptr<const Kinematics>> known;
  auto& joints = known[files.rig_folder];
  if (!joints) joints = std::make_shared<const Kinematics>(read_kinematics(*rig));
  return joints;
}

}  // namespace inbetween
