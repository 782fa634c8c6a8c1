#include "tests/bench/inside/simulated_chip.hpp"

#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "tests/support/run_program.hpp"

namespace inbetween {
namespace {

const std::string gpio_sim = "/sys/kernel/config/gpio-sim/";

void write(const std::string& path, const std::string& text) {
  std::ofstream file(path);
  file << text << std::flush;
  if (!file) throw std::runtime_error("cannot write " + text + " to " + path);
}

std::string word_of(const std::string& path) {
  std::ifstream file(path);
  std::string word;
  if (!(file >> word)) throw std::runtime_error("cannot read " + path);
  return word;
}

}  // namespace

SimulatedChip::SimulatedChip(const std::string& label, unsigned line_count, const std::vector<Line>& lines)
    : line_count_(line_count) {
  static int made = 0;
  folder_ = gpio_sim + "test-" + std::to_string(::getpid()) + "-" + std::to_string(++made);
  const std::string bank = folder_ + "/bank";
  std::filesystem::create_directories(bank);
  write(bank + "/num_lines", std::to_string(line_count));
  write(bank + "/label", label);
  for (const Line& line : lines) {
    const std::string place = bank + "/line" + std::to_string(line.offset);
    std::filesystem::create_directory(place);
    if (!line.name.empty()) write(place + "/name", line.name);
    if (line.user.empty()) continue;
    std::filesystem::create_directory(place + "/hog");
    write(place + "/hog/name", line.user);
    write(place + "/hog/direction", "input");
  }
  write(folder_ + "/live", "1");
  is_plugged_ = true;
  lines_ = "/sys/devices/platform/" + word_of(folder_ + "/dev_name") + "/" + word_of(bank + "/chip_name");
}

SimulatedChip::~SimulatedChip() {
  unplug();
  // Its folders cannot be emptied, only removed from within outwards.
  std::error_code error;
  const std::string bank = folder_ + "/bank";
  for (unsigned i = 0; i < line_count_; ++i) {
    const std::string place = bank + "/line" + std::to_string(i);
    std::filesystem::remove(place + "/hog", error);
    std::filesystem::remove(place, error);
  }
  std::filesystem::remove(bank, error);
  std::filesystem::remove(folder_, error);
}

void SimulatedChip::pull(unsigned line, bool is_up) const {
  write(lines_ + "/sim_gpio" + std::to_string(line) + "/pull", is_up ? "pull-up" : "pull-down");
}

bool SimulatedChip::level(unsigned line) const {
  return word_of(lines_ + "/sim_gpio" + std::to_string(line) + "/value") == "1";
}

unsigned SimulatedChip::levels() const {
  unsigned bits = 0;
  for (unsigned i = 0; i < line_count_; ++i) bits |= level(i) ? 1U << i : 0U;
  return bits;
}

void SimulatedChip::unplug() {
  if (!is_plugged_) return;
  std::ofstream(folder_ + "/live") << "0";
  is_plugged_ = false;
}

void SimulatedChip::settle() {
  // It tells at its next timer tick, every 10 ms.
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
}

bool is_on_virtual_time() {
  return file_contents("/proc/cmdline").find("time-travel") != std::string::npos;
}

}  // namespace inbetween
