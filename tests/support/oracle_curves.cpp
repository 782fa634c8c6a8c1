#include "tests/support/oracle_curves.hpp"

#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <utility>

namespace inbetween::oracle {
namespace {

using MatrixRow = std::vector<long double>;

std::vector<long double> eliminate(std::vector<MatrixRow> rows, std::vector<long double> right) {
  const std::size_t n = right.size();
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < n; ++i) {
      if (std::abs(rows[i][k]) > std::abs(rows[pivot][k])) pivot = i;
    }
    if (rows[pivot][k] == 0) throw std::runtime_error("the conditions of the curve contradict each other");
    std::swap(rows[k], rows[pivot]);
    std::swap(right[k], right[pivot]);
    for (std::size_t i = k + 1; i < n; ++i) {
      const long double factor = rows[i][k] / rows[k][k];
      if (factor == 0) continue;
      for (std::size_t j = k; j < n; ++j) rows[i][j] -= factor * rows[k][j];
      right[i] -= factor * right[k];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) right[k] -= rows[k][j] * right[j];
    right[k] /= rows[k][k];
  }
  return right;
}

/// The conditions on the cubics of all pieces, four unknowns each, as they gather. x runs from 0 to 1 in a
/// piece.
struct CurveConditions {
  std::vector<TimedPiece> pieces;
  std::vector<MatrixRow> rows;
  std::vector<long double> right;

  /// Adds sign times the derivative at the beginning or end of a piece, in frames.
  void add(MatrixRow& row, std::size_t piece, bool at_end, int order, long double sign) const {
    const long double h = pieces[piece].end - pieces[piece].begin;
    for (int power = order; power < 4; ++power) {
      long double factor = 1;
      for (int i = 0; i < order; ++i) factor *= static_cast<long double>(power - i);
      if (!at_end && power > order) factor = 0;
      row[4 * piece + static_cast<std::size_t>(power)] +=
          sign * factor / std::pow(h, static_cast<long double>(order));
    }
  }
  void fix(std::size_t piece, bool at_end, int order, long double value) {
    MatrixRow row(4 * pieces.size());
    add(row, piece, at_end, order, 1);
    rows.push_back(row);
    right.push_back(value);
  }
  void join(std::size_t before, std::size_t behind, int order) {
    MatrixRow row(4 * pieces.size());
    add(row, before, true, order, 1);
    add(row, behind, false, order, -1);
    rows.push_back(row);
    right.push_back(0);
  }
};

}  // namespace

std::vector<TimedPiece> smooth_curve(const TimedKeys& keys) {
  const std::size_t intervals = keys.at.size() - 1;
  const auto is_flat = [&](std::size_t i) {
    return keys.rests_between_equals && keys.at[i] == keys.at[i + 1];
  };
  const auto rests = [&](std::size_t k) {
    if (k == 0 && keys.rests_at_start && !keys.periodic) return true;
    if (k == intervals && keys.rests_at_end && !keys.periodic) return true;
    const bool at_seam = keys.periodic && (k == 0 || k == intervals);
    const bool before = k > 0 ? is_flat(k - 1) : at_seam && is_flat(intervals - 1);
    const bool behind = k < intervals ? is_flat(k) : at_seam && is_flat(0);
    return before || behind;
  };
  CurveConditions all;
  std::vector<std::size_t> first;  // piece of each interval
  for (std::size_t i = 0; i < intervals; ++i) {
    first.push_back(all.pieces.size());
    const long double h = keys.frames[i + 1] - keys.frames[i];
    std::vector<long double> knots = {keys.frames[i]};
    if (!is_flat(i) && rests(i)) knots.push_back(keys.frames[i] + h / 4);
    if (!is_flat(i) && rests(i + 1)) knots.push_back(keys.frames[i + 1] - h / 4);
    knots.push_back(keys.frames[i + 1]);
    for (std::size_t k = 0; k + 1 < knots.size(); ++k) all.pieces.push_back({knots[k], knots[k + 1], {}});
  }
  first.push_back(all.pieces.size());
  for (std::size_t i = 0; i < intervals; ++i) {
    const std::size_t last = first[i + 1] - 1;
    all.fix(first[i], false, 0, keys.at[i]);
    all.fix(last, true, 0, keys.at[i + 1]);
    for (std::size_t piece = first[i]; piece < last; ++piece) {
      for (int order = 0; order <= 2; ++order) all.join(piece, piece + 1, order);
    }
    if (is_flat(i)) {
      all.fix(first[i], false, 1, 0);
      all.fix(first[i], false, 2, 0);
      continue;
    }
    for (const int order : {1, 2}) {
      if (rests(i)) all.fix(first[i], false, order, 0);
      if (rests(i + 1)) all.fix(last, true, order, 0);
      if (!rests(i) && i > 0) all.join(first[i] - 1, first[i], order);
    }
    if (!rests(i) && i == 0) {
      if (keys.periodic) {
        for (const int order : {1, 2}) all.join(all.pieces.size() - 1, 0, order);
      } else {
        all.fix(0, false, 2, 0);
      }
    }
    if (!rests(i + 1) && i + 1 == intervals && !keys.periodic) all.fix(last, true, 2, 0);
  }
  const std::vector<long double> solved = eliminate(all.rows, all.right);
  for (std::size_t piece = 0; piece < all.pieces.size(); ++piece) {
    const long double h = all.pieces[piece].end - all.pieces[piece].begin;
    for (std::size_t power = 0; power < 4; ++power) {
      all.pieces[piece].c[power] = solved[4 * piece + power] / std::pow(h, static_cast<long double>(power));
    }
  }
  return all.pieces;
}

long double curve_at(const std::vector<TimedPiece>& curve, long double frame, int order) {
  std::size_t piece = 0;
  while (piece + 1 < curve.size() && curve[piece + 1].begin <= frame) ++piece;
  const long double x = frame - curve[piece].begin;
  long double sum = 0;
  for (int power = 3; power >= order; --power) {
    long double factor = 1;
    for (int i = 0; i < order; ++i) factor *= static_cast<long double>(power - i);
    sum = sum * x + factor * curve[piece].c[static_cast<std::size_t>(power)];
  }
  return sum;
}

}  // namespace inbetween::oracle
