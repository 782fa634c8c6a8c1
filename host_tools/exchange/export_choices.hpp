// What a file of another program shall have of a motion, and what it cannot have.
#pragma once

#include <string>
#include <vector>

#include "host_tools/exchange/baked_table.hpp"
#include "host_tools/exchange/exchange_format.hpp"
#include "host_tools/exchange/table_words.hpp"

namespace inbetween {

struct ExportChoices {
  std::vector<AxisWord> axes = {};     // columns of the file in their order; empty: every axis, by its name
  std::vector<UnitWord> units = {};    // of columns, or of all that they fit; otherwise those of the rig
  std::vector<CountWord> counts = {};  // of columns that have counts in place of positions
  std::optional<UpAxis> up = {};       // of positions in space
};

/// `table` has the axes of a rig in their units (table_of_plan). Axes that are left out are warnings. Throws
/// InputError at the table where an axis or a column is not there, or a unit does not fit.
BakedTable exported_table(const BakedTable& table, const ExportChoices& choices);

/// What the format does not hold of the table, a line each: who reads the file has to be told it otherwise.
std::vector<std::string> losses_of(ExchangeFormat format, const BakedTable& table,
                                   std::optional<std::int32_t> decimals = {});

}  // namespace inbetween
