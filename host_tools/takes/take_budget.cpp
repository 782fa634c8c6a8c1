#include "host_tools/takes/take_budget.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {
namespace {

constexpr std::array<std::string_view, 3> budget_units = {"mm", "deg", "px"};

std::string_view name_of(TakeBudget::Unit unit) {
  return budget_units.at(static_cast<std::size_t>(unit));
}

/// What a budget may be about.
struct Judged {
  const Measure* measure = nullptr;
  double error = 0;
  double interpolation = 0;
  double frame = 0;
};

/// How many of the unit of the budget a unit of the measure has; nothing where it is not about the measure.
std::optional<double> units_in(const Measure& measure, TakeBudget::Unit unit, bool has_tips) {
  using Kind = Measure::Kind;
  if (unit == TakeBudget::Unit::px) return measure.kind == Kind::picture ? std::optional(1.0) : std::nullopt;
  const bool is_length = unit == TakeBudget::Unit::mm;
  if (has_tips) {
    return measure.kind == (is_length ? Kind::distance : Kind::angle) ? std::optional(1.0) : std::nullopt;
  }
  const std::array<std::pair<std::string_view, double>, 3> known =
      is_length ? std::array<std::pair<std::string_view, double>, 3>{{{"mm", 1}, {"m", 1000}, {"", 0}}}
                : std::array<std::pair<std::string_view, double>, 3>{
                      {{"deg", 1}, {"rad", 180 / std::numbers::pi}, {"turn", 360}}};
  for (const auto& [name, factor] : known) {
    if (measure.unit == name) return factor;
  }
  return std::nullopt;
}

[[noreturn]] void refuse_unit(TakeBudget::Unit unit) {
  throw std::runtime_error(fmt::format(
      "inbetween: error: nothing of the rig is measured in {}; {}", name_of(unit),
      unit == TakeBudget::Unit::px
          ? "add [lens] to the file of the rig, and record takes with it, or give the budget in another unit"
          : "give the budget in another unit"));
}

BudgetVerdict judge_all(const TakeBudget& budget, const std::vector<Judged>& all) {
  const bool has_tips = std::ranges::any_of(
      all, [](const Judged& one) { return one.measure->kind == Measure::Kind::distance; });
  BudgetVerdict verdict;
  const Measure unit{.kind = Measure::Kind::axis, .name = "", .unit = std::string(name_of(budget.unit))};
  bool is_measured = false;
  for (const Judged& one : all) {
    const std::optional<double> factor = units_in(*one.measure, budget.unit, has_tips);
    if (!factor) continue;
    const double largest = *factor * (std::fabs(one.error) + one.interpolation);
    if (is_measured && largest <= verdict.largest) continue;
    is_measured = true;
    verdict.largest = largest;
    verdict.interpolation = *factor * one.interpolation;
    verdict.frame = one.frame;
    verdict.name = one.measure->name;
  }
  if (!is_measured) refuse_unit(budget.unit);
  verdict.holds = verdict.largest <= budget.largest;
  verdict.sentence =
      fmt::format("{} is {}{} at frame {:.0f}, {} the budget of {} {}", in_quotes(verdict.name),
                  std::isfinite(verdict.largest) ? "off by " : "", in_words(verdict.largest, unit),
                  std::floor(verdict.frame), verdict.holds ? "within" : "over", budget.largest, unit.unit);
  return verdict;
}

}  // namespace

TakeBudget parse_budget(std::string_view text) {
  TakeBudget budget;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), budget.largest);
  std::string_view unit = text.substr(static_cast<std::size_t>(end - text.data()));
  while (unit.starts_with(' ')) unit.remove_prefix(1);
  const auto known = std::ranges::find(budget_units, unit);
  if (error != std::errc() || known == budget_units.end() || !(budget.largest >= 0) ||
      !std::isfinite(budget.largest)) {
    throw std::runtime_error(fmt::format(
        "inbetween: error: {} is no budget; write a number from 0 with mm, deg or px, such as 1px or 0.2mm",
        in_quotes(text)));
  }
  budget.unit = static_cast<TakeBudget::Unit>(known - budget_units.begin());
  return budget;
}

BudgetVerdict judge(const TakeBudget& budget, const TakeComparison& comparison) {
  std::vector<Judged> all;
  for (const TakeComparison::Of& of : comparison.measures) {
    const ErrorFigures& figures = of.errors.all();
    all.push_back({&of.measure, figures.worst(), of.interpolation, in_frames(figures.worst_at())});
  }
  return judge_all(budget, all);
}

BudgetVerdict judge(const TakeBudget& budget, const TakeErrors& errors) {
  if (errors.samples == 0) {
    throw std::runtime_error(
        fmt::format("inbetween: error: take {} has no tick of the move; a budget needs one", errors.number));
  }
  std::vector<Judged> all;
  for (const TakeErrors::Of& of : errors.measures) {
    const ErrorFigures& figures = of.errors.all();
    all.push_back({&of.measure, figures.worst(), 0, in_frames(figures.worst_at())});
  }
  return judge_all(budget, all);
}

}  // namespace inbetween
