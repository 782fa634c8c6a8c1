// The arguments of `inbetween takes`, which its subcommands share.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/cli/command.hpp"
#include "host_tools/takes/take_budget.hpp"
#include "host_tools/takes/take_store.hpp"

namespace inbetween {

struct TakesArguments {
  int (*act)(const TakesArguments&) = nullptr;  ///< of the subcommand that is named
  std::optional<std::string> in, json, csv, trajectory, plot;
  std::vector<std::int64_t> takes;
  std::optional<std::int64_t> max_bytes;
  std::optional<TakeBudget> budget;
  bool is_not = false;
  bool has_errors = false;
  bool is_trend = false;
  PictureStyle style = PictureStyle::light;
};

/// Opens the file that --in means. Throws TakeStoreError.
TakeStore opened(const TakesArguments& arguments, TakeStore::Access access = TakeStore::Access::read);

}  // namespace inbetween
