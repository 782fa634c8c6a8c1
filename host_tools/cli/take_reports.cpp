#include "host_tools/cli/take_reports.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host_tools/takes/take_compare.hpp"
#include "host_tools/takes/take_errors.hpp"
#include "host_tools/takes/take_errors_output.hpp"
#include "host_tools/takes/take_passes.hpp"
#include "host_tools/takes/take_trend.hpp"
#include "host_tools/takes/taken_rig.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/json_writer.hpp"
#include "host_tools/text/output_file.hpp"

namespace inbetween {
namespace {

/// A take as it is measured, with the rig that it was played on.
struct MeasuredTake {
  TakenRig rig;
  TakeSamples samples;
};

MeasuredTake measured_take(TakeStore& store, std::int64_t number) {
  const Take take = store.read(number);
  return {rig_of(take), TakeSamples(take)};
}

RigMeasures measures_of(const MeasuredTake& take) {
  return {take.rig.rig, take.rig.kinematics};
}

template <class Write>
void write_json(const std::optional<std::string>& name, const Write& write) {
  if (!name) return;
  write_output(*name, [&](std::FILE* file) {
    JsonWriter json(file);
    json.begin_object();
    write(json);
    json.end_object();
    json.finish();
  });
}

template <class Figures>
std::optional<BudgetVerdict> verdict_of(const TakesArguments& arguments, const Figures& figures) {
  if (!arguments.budget) return std::nullopt;
  return judge(*arguments.budget, figures);
}

bool is_exceeded(const std::optional<BudgetVerdict>& verdict) {
  return verdict && !verdict->holds;
}

}  // namespace

int show_errors(const TakesArguments& arguments) {
  TakeStore store = opened(arguments);
  const MeasuredTake take = measured_take(store, arguments.takes.front());
  const TakeErrors errors = errors_of(take.samples, measures_of(take));
  const std::optional<BudgetVerdict> verdict = verdict_of(arguments, errors);
  write_json(arguments.json, [&](JsonWriter& json) { write_errors(json, errors, verdict); });
  if (arguments.json != "-") print_errors(errors, verdict, stdout);
  return is_exceeded(verdict) ? exit_limit : 0;
}

int compare_takes(const TakesArguments& arguments) {
  TakeStore store = opened(arguments);
  const MeasuredTake first = measured_take(store, arguments.takes.front());
  const RigMeasures measures = measures_of(first);
  std::vector<TakeSamples> passes{first.samples};
  std::vector<TakeComparison> comparisons;
  std::vector<std::optional<BudgetVerdict>> verdicts;
  for (auto take = arguments.takes.begin() + 1; take != arguments.takes.end(); ++take) {
    passes.emplace_back(store.read(*take));
    comparisons.push_back(compare_takes(passes.front(), passes.back(), measures));
    verdicts.push_back(verdict_of(arguments, comparisons.back()));
  }
  std::optional<PathReport> report;
  if (passes.size() > 2) report = path_report(passes, measures);
  std::size_t next = 0;
  write_json(arguments.json, [&](JsonWriter& json) {
    if (!report) return write_comparison(json, comparisons.front(), verdicts.front());
    write_path_report(json, *report);
    json.objects("comparisons", comparisons, [&](const TakeComparison& comparison) {
      write_comparison(json, comparison, verdicts[next++]);
    });
  });
  if (arguments.json != "-") {
    for (std::size_t i = 0; i < comparisons.size(); ++i)
      print_comparison(comparisons[i], verdicts[i], stdout);
    if (report) print_path_report(*report, stdout);
  }
  return std::ranges::any_of(verdicts, is_exceeded) ? exit_limit : 0;
}

int plot_trend(const TakesArguments& arguments) {
  TakeStore store = opened(arguments);
  std::vector<std::int64_t> numbers = arguments.takes;
  const std::vector<TakeInfo> all = store.list();
  if (numbers.empty() && !all.empty()) {
    for (const TakeInfo& take : all) {
      if (take.move_name == all.back().move_name && take.rig_name == all.back().rig_name)
        numbers.push_back(take.number);
    }
  }
  if (numbers.empty())
    throw TakeStoreError(store.file(), "there are no takes in it; inbetween run keeps them");
  std::vector<TakeTrend> trends;
  std::string name;
  for (const std::int64_t number : numbers) {
    const Take take = store.read(number);
    name = fmt::format("{} on {}", take.move_name, take.rig_name);
    trends.push_back(trend_of(TakeSamples(take), rig_of(take).rig));
  }
  write_json(arguments.json, [&](JsonWriter& json) { write_trends(json, trends); });
  draw_trend_plot(trend_plot(name, trends), *arguments.plot, arguments.style);
  if (arguments.json == "-") return 0;
  print_trends(trends, stdout);
  fmt::print("{}: {} drawn\n", *arguments.plot,
             trends.size() == 1
                 ? "1 take is"
                 : fmt::format("{} are", counted(static_cast<std::int64_t>(trends.size()), "take")));
  return 0;
}

}  // namespace inbetween
