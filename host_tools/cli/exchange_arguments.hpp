// The arguments that import and export share: what columns of a file are, in both directions the same.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/exchange/exchange_format.hpp"
#include "host_tools/exchange/table_words.hpp"

namespace inbetween {

struct ExchangeArguments {
  std::vector<std::string> axes, units, counts;
  std::optional<std::string> fps, up, phase, format;
  std::optional<std::int64_t> take;
  bool is_measured = false;
  bool may_overwrite = false;
};

/// Adds --axis, --unit, --count, --fps, --up, --phase, --format, --take, --measured and --over.
void add_exchange_options(CLI::App& app, ExchangeArguments& arguments);

/// The same in their types.
struct ExchangeWords {
  std::vector<AxisWord> axes;
  std::vector<UnitWord> units;
  std::vector<CountWord> counts;
  std::optional<FrameRate> fps;
  std::optional<UpAxis> up;
  std::optional<ShutterPhase> phase;
  std::optional<ExchangeFormat> format;
};
/// Throws UsageError at the first that is none.
ExchangeWords exchange_words_of(const ExchangeArguments& arguments);

/// Throws InputError where a file is there and nobody said --over. What is no file of bytes is written to.
void refuse_to_overwrite(const std::string& file, bool may_overwrite);

}  // namespace inbetween
