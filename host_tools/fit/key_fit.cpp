#include "host_tools/fit/key_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "host_tools/numerics/symmetric_matrix.hpp"

namespace inbetween {
namespace {

/// A key bends a smooth path less by a factor of 3.7 with each key farther on: beyond so many keys nothing is
/// left of it.
constexpr double key_reach = 6;
/// A point slides so far along the path in one step, in segments: half a segment either way holds the nearest
/// place, and no place beyond a neighbouring key.
constexpr double slide_reach = 0.5;

PathPoint point_of(const Path& path, double s) {
  const std::int32_t segment = std::clamp(static_cast<std::int32_t>(s), 0, path.segment_count() - 1);
  return {segment, s - segment};
}

std::vector<Cubic> cubics_of(const PassedPoints& points, std::span<const double> keys,
                             std::vector<double>& weights, std::optional<Path>& path) {
  std::vector<Cubic> cubics(keys.size() + points.axes);
  PathSpec spec;
  spec.axis_count = static_cast<std::int32_t>(points.axes);
  spec.keys = keys;
  spec.weights = points.weights;
  const Result<Path> made = Path::make(spec, {cubics, weights});
  path = made ? std::optional(*made) : std::nullopt;
  return cubics;
}

/// The rising sequence that is nearest to the given one (pool adjacent violators, Ayer and others 1955).
void make_rising(std::vector<double>& sequence) {
  struct Block {
    double sum = 0;
    std::size_t count = 0;
    [[nodiscard]] double mean() const { return sum / static_cast<double>(count); }
  };
  std::vector<Block> blocks;
  for (const double one : sequence) {
    blocks.push_back({one, 1});
    while (blocks.size() > 1 && blocks[blocks.size() - 2].mean() >= blocks.back().mean()) {
      const Block last = blocks.back();
      blocks.pop_back();
      blocks.back().sum += last.sum;
      blocks.back().count += last.count;
    }
  }
  auto place = sequence.begin();
  for (const Block& block : blocks) place = std::fill_n(place, block.count, block.mean());
}

}  // namespace

KeyFit::KeyFit(const PassedPoints& points, std::vector<double> keys, std::vector<double> places)
    : points_(&points),
      keys_(std::move(keys)),
      places_(std::move(places)),
      squares_(places_.size()),
      weights_(points.axes) {
  for (std::size_t a = 0; a < points.axes; ++a) {
    if (points.scales[a] > 0) counted_.push_back(a);
  }
  make_path();
  if (path_) slide(1);
}

void KeyFit::make_path() {
  cubics_ = cubics_of(*points_, keys_, weights_, path_);
}

double KeyFit::square_at(std::size_t point, double s) const {
  const PathPoint place = point_of(*path_, s);
  double square = 0;
  for (const std::size_t a : counted_) {
    const double offset = (path_->position(place, static_cast<std::int32_t>(a)) -
                           points_->positions[point * points_->axes + a]) *
                          points_->scales[a];
    square += offset * offset;
  }
  return square;
}

/// The first point is at the begin and the last at the end, so that the path goes no farther than they do.
/// Every other one goes to the nearest place around its own, but they keep their order: the best of a few,
/// and from there by golden section.
void KeyFit::slide(double reach) {
  constexpr int tries = 12;  // a segment is a cubic: a piece so short has one place that is nearest
  constexpr double golden = 0.6180339887498949;
  const double last = path_->segment_count();
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const bool is_first = i == 0;
    const bool is_last = i + 1 == places_.size();
    const double begin = is_last ? last : std::max(is_first ? 0 : places_[i] - reach, 0.0);
    const double end = is_first ? 0 : std::min(is_last ? last : places_[i] + reach, last);
    const double step = (end - begin) / tries;
    double best = std::clamp(places_[i], begin, end);
    double least = square_at(i, best);
    for (int k = 0; k <= tries; ++k) {
      const double square = square_at(i, begin + k * step);
      if (square < least) least = square, best = begin + k * step;
    }
    double low = std::max(begin, best - step);
    double high = std::min(end, best + step);
    while (high - low > 1e-7) {
      const double one = high - golden * (high - low);
      const double other = low + golden * (high - low);
      if (square_at(i, one) <= square_at(i, other)) {
        high = other;
      } else {
        low = one;
      }
    }
    const double found = (low + high) / 2;
    places_[i] = square_at(i, found) < least ? found : best;
  }
  make_rising(places_);
  for (std::size_t i = 0; i < places_.size(); ++i) squares_[i] = square_at(i, places_[i]);
}

double KeyFit::mean_square() const {
  return std::accumulate(squares_.begin(), squares_.end(), 0.0) / static_cast<double>(squares_.size());
}

std::size_t KeyFit::farthest() const {
  return static_cast<std::size_t>(std::ranges::max_element(squares_) - squares_.begin());
}

double KeyFit::distance(std::size_t point) const {
  return std::sqrt(squares_[point]);
}

std::vector<double> KeyFit::misses() const {
  std::vector<double> misses;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const PathPoint place = point_of(*path_, places_[i]);
    for (const std::size_t a : counted_) {
      misses.push_back(
          (points_->positions[i * points_->axes + a] - path_->position(place, static_cast<std::int32_t>(a))) *
          points_->scales[a]);
    }
  }
  return misses;
}

double KeyFit::deviation() const {
  const std::size_t d = counted_.size();
  const std::vector<double> all = misses();
  double most = 0;
  for (std::size_t i = d; i + 2 * d <= all.size(); i += d) {
    double square = 0;
    for (std::size_t a = i; a < i + d; ++a) square += std::pow((all[a - d] + all[a] + all[a + d]) / 3, 2);
    most = std::max(most, square);
  }
  return std::sqrt(most);
}

/// What sliding along the path would take away of it is left out. At an end of the path nothing slides.
std::optional<KeyFit::Effects> KeyFit::effects_of_keys() const {
  const std::size_t d = counted_.size();
  const double last = path_->segment_count();
  Effects effects{std::vector<std::vector<double>>(places_.size() * d),
                  std::vector<std::size_t>(places_.size())};
  std::vector<std::vector<double>> tangents(places_.size());
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const auto first = static_cast<std::size_t>(std::max(std::ceil(places_[i] - key_reach), 0.0));
    const auto end = static_cast<std::size_t>(std::min(std::floor(places_[i] + key_reach), last)) + 1;
    effects.first_column[i] = first * d;
    for (std::size_t a = 0; a < d; ++a) effects.rows[i * d + a].resize((end - first) * d);
    const PathPoint place = point_of(*path_, places_[i]);
    double length = 0;
    for (const std::size_t a : counted_) {
      tangents[i].push_back(path_->segment(place.segment)[a].derivative(place.t) * points_->scales[a]);
      length += tangents[i].back() * tangents[i].back();
    }
    const bool slides = places_[i] > 0 && places_[i] < last && length > 0;
    for (double& one : tangents[i]) one = slides ? one / std::sqrt(length) : 0;
  }
  std::vector<double> weights(points_->axes);
  for (std::size_t column = 0; column < key_count() * d; ++column) {
    const std::size_t key = column / d;
    const std::size_t axis = counted_[column % d];
    std::vector<double> shifted = keys_;
    shifted[key * points_->axes + axis] += 1e-4 / points_->scales[axis];
    std::optional<Path> other;
    const std::vector<Cubic> cubics = cubics_of(*points_, shifted, weights, other);
    if (!other) return std::nullopt;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (std::fabs(places_[i] - static_cast<double>(key)) > key_reach) continue;
      const PathPoint place = point_of(*path_, places_[i]);
      const std::size_t at = column - effects.first_column[i];
      double along = 0;
      for (std::size_t a = 0; a < d; ++a) {
        const auto row = static_cast<std::int32_t>(counted_[a]);
        const double by =
            (other->position(place, row) - path_->position(place, row)) * points_->scales[counted_[a]] * 1e4;
        effects.rows[i * d + a][at] = by;
        along += by * tangents[i][a];
      }
      for (std::size_t a = 0; a < d; ++a) effects.rows[i * d + a][at] -= along * tangents[i][a];
    }
  }
  return effects;
}

bool KeyFit::step(double& damping) {
  const std::size_t d = counted_.size();
  const std::size_t n = key_count() * d;
  const std::optional<Effects> effects = effects_of_keys();
  if (!effects) return false;
  const std::vector<std::vector<double>>& rows = effects->rows;
  std::vector<double> gram(n * n);
  std::vector<double> right(n);
  const std::vector<double> missed = misses();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::size_t first = effects->first_column[i / d];
    for (std::size_t j = 0; j < rows[i].size(); ++j) {
      right[first + j] += rows[i][j] * missed[i];
      for (std::size_t k = 0; k < rows[i].size(); ++k)
        gram[(first + j) * n + first + k] += rows[i][j] * rows[i][k];
    }
  }
  const double before = mean_square();
  const std::vector<double> keys = keys_;
  const std::vector<double> places = places_;
  const double mean = static_cast<double>(places_.size()) / static_cast<double>(key_count());
  for (int tries = 0; tries < 6; ++tries) {
    std::vector<double> damped = gram;
    for (std::size_t j = 0; j < n; ++j) damped[j * n + j] += damping * mean;
    const std::vector<double> by = solved(damped, right);
    for (std::size_t j = 0; j < n; ++j)
      keys_[j / d * points_->axes + counted_[j % d]] =
          keys[j / d * points_->axes + counted_[j % d]] + by[j] / points_->scales[counted_[j % d]];
    make_path();
    if (path_) {
      slide(slide_reach);
      if (mean_square() < before) {
        damping = std::max(damping / 10, 1e-9);
        return true;
      }
    }
    damping *= 10;
  }
  keys_ = keys;
  places_ = places;
  make_path();
  slide(slide_reach);
  return false;
}

void KeyFit::descend(int steps) {
  double damping = 1e-3;
  for (int i = 0; i < steps; ++i) {
    const double before = mean_square();
    if (!step(damping) || mean_square() > 0.999 * before) return;
  }
}

double KeyFit::excursion() const {
  constexpr int looks = 8;  // between two points: enough to see a loop, which is longer than their distance
  double most = 0;
  for (std::size_t i = 0; i + 1 < places_.size(); ++i) {
    for (int k = 1; k < looks; ++k) {
      const double s = places_[i] + (places_[i + 1] - places_[i]) * k / looks;
      const PathPoint place = point_of(*path_, s);
      double chord = 0;
      double along = 0;
      double square = 0;
      for (const std::size_t a : counted_) {
        const double from = points_->positions[i * points_->axes + a];
        const double offset = (points_->positions[(i + 1) * points_->axes + a] - from) * points_->scales[a];
        const double out = (path_->position(place, static_cast<std::int32_t>(a)) - from) * points_->scales[a];
        chord += offset * offset;
        along += offset * out;
        square += out * out;
      }
      const double share = chord > 0 ? std::clamp(along / chord, 0.0, 1.0) : 0;
      most = std::max(most, square - share * (2 * along - share * chord));
    }
  }
  return std::sqrt(most);
}

bool KeyFit::split_worst(double shortest) {
  // Noise changes its sign from point to point. What neighbours have in common is a miss of the path.
  const std::size_t d = counted_.size();
  const std::vector<double> missed = misses();
  std::vector<double> shared(static_cast<std::size_t>(path_->segment_count()));
  for (std::size_t i = d; i < missed.size(); ++i)
    shared[static_cast<std::size_t>(point_of(*path_, places_[i / d]).segment)] += missed[i] * missed[i - d];
  for (std::size_t k = 0; k < shared.size(); ++k) {
    double chord = 0;
    for (const std::size_t a : counted_)
      chord += std::pow(
          (keys_[(k + 1) * points_->axes + a] - keys_[k * points_->axes + a]) * points_->scales[a], 2);
    if (chord < 4 * shortest * shortest) shared[k] = -std::numeric_limits<double>::infinity();
  }
  const auto worst = static_cast<std::size_t>(std::ranges::max_element(shared) - shared.begin());
  if (shared[worst] == -std::numeric_limits<double>::infinity()) return false;
  std::vector<double> key;
  for (std::size_t a = 0; a < points_->axes; ++a)
    key.push_back(path_->position({static_cast<std::int32_t>(worst), 0.5}, static_cast<std::int32_t>(a)));
  keys_.insert(keys_.begin() + static_cast<std::ptrdiff_t>((worst + 1) * points_->axes), key.begin(),
               key.end());
  const auto begin = static_cast<double>(worst);
  for (double& s : places_) {
    if (s > begin + 1) {
      s += 1;
    } else if (s > begin) {
      s = begin + 2 * (s - begin);
    }
  }
  make_path();
  if (path_) slide(slide_reach);
  return path_.has_value();
}

}  // namespace inbetween
