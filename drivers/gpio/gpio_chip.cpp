#include "drivers/gpio/gpio_chip.hpp"

#include <gpiod.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace inbetween::gpio {
namespace {

/// The name that other programs see as the user of our lines.
constexpr const char* consumer = "inbetween";
/// The most that the kernel keeps; more than it would by itself, for a switch that chatters.
constexpr std::size_t kept_events = 1024;

template <auto free>
struct Free {
  template <class Thing>
  void operator()(Thing* thing) const {
    free(thing);
  }
};
using ChipInfo = std::unique_ptr<gpiod_chip_info, Free<gpiod_chip_info_free>>;
using LineInfo = std::unique_ptr<gpiod_line_info, Free<gpiod_line_info_free>>;
using LineSettings = std::unique_ptr<gpiod_line_settings, Free<gpiod_line_settings_free>>;
using LineConfig = std::unique_ptr<gpiod_line_config, Free<gpiod_line_config_free>>;
using RequestConfig = std::unique_ptr<gpiod_request_config, Free<gpiod_request_config_free>>;

std::string reason_of(int error) {
  return std::strerror(error);
}

/// The files of all chips, each once: some machines have links with the names of other chips among them.
std::vector<std::string> chip_paths() {
  std::vector<std::string> paths;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/dev", error)) {
    const bool is_named_so = entry.path().filename().string().rfind("gpiochip", 0) == 0;
    if (is_named_so && !entry.is_symlink(error) && gpiod_is_gpiochip_device(entry.path().c_str())) {
      paths.push_back(entry.path().string());
    }
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

std::string label_of(gpiod_chip* chip) {
  const ChipInfo info(gpiod_chip_get_info(chip));
  return info ? gpiod_chip_info_get_label(info.get()) : "";
}

std::vector<std::string> line_names_of(gpiod_chip* chip) {
  const ChipInfo info(gpiod_chip_get_info(chip));
  std::vector<std::string> names(info ? gpiod_chip_info_get_num_lines(info.get()) : 0);
  for (unsigned i = 0; i < names.size(); ++i) {
    const LineInfo line(gpiod_chip_get_line_info(chip, i));
    const char* name = line ? gpiod_line_info_get_name(line.get()) : nullptr;
    if (name != nullptr) names[i] = name;
  }
  return names;
}

gpiod_line_bias to_kernel(Bias bias) {
  switch (bias) {
    case Bias::none:
      return GPIOD_LINE_BIAS_DISABLED;
    case Bias::pull_up:
      return GPIOD_LINE_BIAS_PULL_UP;
    case Bias::pull_down:
      return GPIOD_LINE_BIAS_PULL_DOWN;
    case Bias::as_it_is:
      break;
  }
  return GPIOD_LINE_BIAS_AS_IS;
}

bool describe(const LineUse& use, gpiod_line_settings* settings) {
  gpiod_line_settings_reset(settings);
  gpiod_line_settings_set_active_low(settings, use.is_inverted);
  if (use.is_output) {
    return gpiod_line_settings_set_direction(settings, GPIOD_LINE_DIRECTION_OUTPUT) == 0 &&
           gpiod_line_settings_set_output_value(
               settings, use.level ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE) == 0;
  }
  return gpiod_line_settings_set_direction(settings, GPIOD_LINE_DIRECTION_INPUT) == 0 &&
         gpiod_line_settings_set_bias(settings, to_kernel(use.bias)) == 0 &&
         gpiod_line_settings_set_edge_detection(settings, GPIOD_LINE_EDGE_BOTH) == 0 &&
         gpiod_line_settings_set_event_clock(settings, GPIOD_LINE_CLOCK_MONOTONIC) == 0;
}

/// None, with errno, where it was refused.
gpiod_line_request* request(gpiod_chip* chip, std::span<const LineUse> lines) {
  const LineSettings settings(gpiod_line_settings_new());
  const LineConfig lines_config(gpiod_line_config_new());
  const RequestConfig request_config(gpiod_request_config_new());
  if (!settings || !lines_config || !request_config) return nullptr;
  gpiod_request_config_set_consumer(request_config.get(), consumer);
  gpiod_request_config_set_event_buffer_size(request_config.get(), kept_events);
  for (const LineUse& use : lines) {
    if (!describe(use, settings.get()) ||
        gpiod_line_config_add_line_settings(lines_config.get(), &use.offset, 1, settings.get()) != 0) {
      return nullptr;
    }
  }
  return gpiod_chip_request_lines(chip, request_config.get(), lines_config.get());
}

}  // namespace

ChipState state_after(int error) {
  if (error == 0) return ChipState::there;
  return error == ENODEV ? ChipState::gone : ChipState::failed;
}

void GiveBack::operator()(gpiod_line_request* request) const {
  gpiod_line_request_release(request);
}

void GpioChip::Close::operator()(gpiod_chip* chip) const {
  gpiod_chip_close(chip);
}

GpioChip::GpioChip() = default;
GpioChip::~GpioChip() = default;

std::optional<Refusal> GpioChip::open(const std::string& label) {
  chip_.reset();
  label_ = label;
  line_names_.clear();
  std::string unreadable;
  std::size_t found = 0;
  for (const std::string& path : chip_paths()) {
    std::unique_ptr<gpiod_chip, Close> chip(gpiod_chip_open(path.c_str()));
    if (!chip) {
      unreadable = path + " cannot be opened: " + reason_of(errno);
    } else if (label_of(chip.get()) == label) {
      chip_ = std::move(chip);
      ++found;
    }
  }
  if (found == 1) {
    line_names_ = line_names_of(chip_.get());
    return std::nullopt;
  }
  chip_.reset();
  if (found > 1) {
    return Refusal{.what = std::to_string(found) + " GPIO chips are labelled " + label,
                   .remedy = "unplug all but one of them: nothing else tells them apart"};
  }
  if (!unreadable.empty()) {
    return Refusal{.what = "no GPIO chip labelled " + label + " is found, and " + unreadable,
                   .remedy = "run as root, or add your user to the group of that file"};
  }
  return Refusal{.what = "there is no GPIO chip labelled " + label,
                 .remedy = "look at the labels, in brackets, with: gpiodetect"};
}

std::optional<Refusal> GpioChip::open_with_line(const std::string& name) {
  chip_.reset();
  std::string label;
  std::string unreadable;
  std::ptrdiff_t found = 0;
  for (const std::string& path : chip_paths()) {
    const std::unique_ptr<gpiod_chip, Close> chip(gpiod_chip_open(path.c_str()));
    if (!chip) {
      unreadable = path + " cannot be opened: " + reason_of(errno);
      continue;
    }
    const std::vector<std::string> names = line_names_of(chip.get());
    const std::ptrdiff_t same = std::count(names.begin(), names.end(), name);
    if (same > 0) label = label_of(chip.get());
    found += same;
  }
  if (found == 1) return open(label);
  if (found > 1) {
    return Refusal{.what = std::to_string(found) + " GPIO lines are named " + name,
                   .remedy = "say which chip it is on"};
  }
  if (!unreadable.empty()) {
    return Refusal{.what = "no GPIO line named " + name + " is found, and " + unreadable,
                   .remedy = "run as root, or add your user to the group of that file"};
  }
  return Refusal{.what = "there is no GPIO line named " + name,
                 .remedy = "look at the lines of all chips with: gpioinfo"};
}

std::string GpioChip::name_of(unsigned offset) const {
  const std::string& name = line_names_[offset];
  return "line " + std::to_string(offset) + (name.empty() ? "" : " (" + name + ")") + " of chip " + label_;
}

std::optional<Refusal> GpioChip::find_one(const LineChoice& line, unsigned& offset) const {
  constexpr const char* remedy = "look at the lines of all chips with: gpioinfo";
  if (const unsigned* number = std::get_if<unsigned>(&line)) {
    offset = *number;
    if (offset < line_names_.size()) return std::nullopt;
    return Refusal{.what = "chip " + label_ + " has no line " + std::to_string(offset) + ", it has " +
                           std::to_string(line_names_.size()) + " lines from 0",
                   .remedy = remedy};
  }
  const auto& name = std::get<std::string>(line);
  const auto same = name.empty() ? 0 : std::count(line_names_.begin(), line_names_.end(), name);
  if (same == 0) {
    return Refusal{.what = "chip " + label_ + " has no line named " + name, .remedy = remedy};
  }
  if (same > 1) {
    return Refusal{.what = "chip " + label_ + " has " + std::to_string(same) + " lines named " + name,
                   .remedy = "give the number of the line instead"};
  }
  offset =
      static_cast<unsigned>(std::find(line_names_.begin(), line_names_.end(), name) - line_names_.begin());
  return std::nullopt;
}

std::optional<Refusal> GpioChip::refuse_busy(unsigned offset) const {
  const LineInfo info(gpiod_chip_get_line_info(chip_.get(), offset));
  if (!info) {
    return Refusal{.what = name_of(offset) + " cannot be asked for: " + reason_of(errno),
                   .remedy = "look whether the chip is still there with: gpiodetect"};
  }
  if (!gpiod_line_info_is_used(info.get())) return std::nullopt;
  const char* user = gpiod_line_info_get_consumer(info.get());
  return Refusal{.what = name_of(offset) + " is in use by " +
                         (user != nullptr ? user : "the kernel, for something else"),
                 .remedy = "end that program, or keep the driver of that name from using the line"};
}

std::optional<Refusal> GpioChip::find(std::span<const LineChoice> lines,
                                      std::vector<unsigned>& offsets) const {
  offsets.clear();
  if (!is_open()) return Refusal{.what = "no GPIO chip is open", .remedy = "open it first"};
  for (const LineChoice& line : lines) {
    unsigned offset = 0;
    if (std::optional<Refusal> refusal = find_one(line, offset)) return refusal;
    if (std::find(offsets.begin(), offsets.end(), offset) != offsets.end()) {
      return Refusal{.what = name_of(offset) + " is asked for twice", .remedy = "give each line one use"};
    }
    offsets.push_back(offset);
  }
  for (const unsigned offset : offsets) {
    if (std::optional<Refusal> refusal = refuse_busy(offset)) return refusal;
  }
  return std::nullopt;
}

std::optional<Refusal> GpioChip::take(std::span<const LineUse> lines, HeldLines& held) const {
  if (!is_open()) return Refusal{.what = "no GPIO chip is open", .remedy = "open it first"};
  if (lines.empty() || lines.size() > max_lines) {
    return Refusal{.what = std::to_string(lines.size()) + " lines of chip " + label_ +
                           " are asked for at once, and the kernel gives 1 to " + std::to_string(max_lines),
                   .remedy = "use fewer lines of this chip"};
  }
  held.reset(request(chip_.get(), lines));
  if (held) return std::nullopt;
  const int error = errno;
  if (error == EBUSY) {
    // Somebody was faster than the look at the lines, and nothing has been changed.
    for (const LineUse& use : lines) {
      if (std::optional<Refusal> refusal = refuse_busy(use.offset)) return refusal;
    }
  }
  if (error == ENXIO) {
    return Refusal{.what = "a line of chip " + label_ + " cannot tell of its edges: it has no interrupt",
                   .remedy = "use another chip for inputs"};
  }
  return Refusal{.what = "lines of chip " + label_ + " cannot be taken: " + reason_of(error),
                 .remedy = "look at the lines of all chips with: gpioinfo"};
}

}  // namespace inbetween::gpio
