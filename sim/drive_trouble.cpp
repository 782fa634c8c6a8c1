#include "sim/drive_trouble.hpp"

#include <algorithm>

namespace inbetween {
namespace {

constexpr std::int64_t ns_per_s = 1'000'000'000;

bool is_there(const DriveTrouble& trouble, std::int64_t now_ns) {
  return now_ns >= trouble.at_ns && now_ns - trouble.at_ns < trouble.for_ns;
}

}  // namespace

std::optional<DriveTrouble> DriveTroubles::begin_next(std::int64_t now_ns) {
  for (Met& met : met_) {
    if (met.is_begun || now_ns < met.trouble.at_ns) continue;
    met.is_begun = true;
    return met.trouble;
  }
  return {};
}

const DriveTrouble* DriveTroubles::find(Kind kind, std::int64_t now_ns) const {
  for (const Met& met : met_) {
    if (met.trouble.kind == kind && is_there(met.trouble, now_ns)) return &met.trouble;
  }
  return nullptr;
}

bool DriveTroubles::has(Kind kind, std::int64_t now_ns) const {
  return find(kind, now_ns) != nullptr;
}

std::int32_t DriveTroubles::value(Kind kind, std::int64_t now_ns) const {
  const DriveTrouble* const trouble = find(kind, now_ns);
  return trouble == nullptr ? 0 : trouble->value;
}

std::optional<double> DriveTroubles::place(Kind kind, std::int64_t now_ns) const {
  const DriveTrouble* const trouble = find(kind, now_ns);
  return trouble == nullptr ? std::nullopt : std::optional(trouble->place);
}

bool DriveTroubles::takes_frame(Kind kind, std::int64_t now_ns) {
  for (Met& met : met_) {
    const DriveTrouble& trouble = met.trouble;
    if (trouble.kind != kind || !is_there(trouble, now_ns) || met.frames >= trouble.frames) continue;
    ++met.frames;
    return true;
  }
  return false;
}

std::int64_t DriveTroubles::flood(std::int64_t now_ns) {
  std::int64_t due = 0;
  for (Met& met : met_) {
    const DriveTrouble& trouble = met.trouble;
    if (trouble.kind != Kind::flood || !is_there(trouble, now_ns)) continue;
    const std::int64_t sent = (now_ns - trouble.at_ns) / 1000 * trouble.value / (ns_per_s / 1000);
    if (sent <= met.frames) continue;
    due += sent - met.frames;
    met.frames = sent;
  }
  return due;
}

}  // namespace inbetween
