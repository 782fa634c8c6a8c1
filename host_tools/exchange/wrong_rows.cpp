#include "host_tools/exchange/wrong_rows.hpp"

#include <fmt/format.h>

namespace inbetween {

void WrongRows::add(const InputError& error) {
  if (!first_) first_ = error;
  if (count_ < max_named) lines_ += (count_ == 0 ? "" : "\n") + std::string(error.what());
  if (++count_ == max_counted) refuse();
}

void WrongRows::refuse() const {
  if (count_ == 0) return;
  if (count_ == 1) throw InputError(*first_);
  std::string lines = lines_;
  if (count_ > max_named) {
    lines += fmt::format("\n{}: error: {}{} more rows are wrong; correct those above first", file_,
                         count_ - max_named, count_ == max_counted ? " or" : "");
  }
  throw WrongRowsError(*first_, lines);
}

}  // namespace inbetween
