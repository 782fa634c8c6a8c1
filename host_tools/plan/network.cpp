#include "host_tools/plan/network.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host_tools/plan/row_spline.hpp"

namespace inbetween {
namespace {

/// Rests put knots on quarters of the segment between two keys, which are whole quarters of frames.
constexpr std::int64_t quarters_per_frame = 4;
/// Segments between two keys beside a rest.
constexpr std::size_t max_parts_per_frame = 4;

/// As a share of the range of an axis: what a number may lose that is written in a file and converted to
/// another unit.
constexpr double closed_share = 1e-9;
/// In ulp of the largest number of the axis, where the range is small beside that: what evaluating a cubic
/// may lose.
constexpr double max_gap_ulps = 8;

Cubic plus(const Cubic& a, double weight, const Cubic& b) {
  return {a.c0 + weight * b.c0, a.c1 + weight * b.c1, a.c2 + weight * b.c2, a.c3 + weight * b.c3};
}

std::vector<FrameSpline> drawn_curves(const NetworkSpec& spec) {
  std::vector<FrameSpline> drawn;
  for (std::size_t i = 0; i < spec.curves.size(); ++i) {
    const NetworkCurve& curve = spec.curves[i];
    try {
      drawn.emplace_back(curve.frames, curve.at, 1, spec.rests_at_start, spec.rests_at_end);
    } catch (const SolverError& refused) {
      throw CurveError(refused.error(), i);
    }
  }
  return drawn;
}

}  // namespace

FrameSpline::FrameSpline(std::span<const std::int32_t> frames, std::span<const double> at, std::size_t axes,
                         bool rests_at_start, bool rests_at_end)
    : axes_(axes) {
  const std::size_t most = max_parts_per_frame * frames.size();
  std::vector<double> weights(axes);
  std::vector<FrameKnot> knots(most);
  cubics_.resize(most * axes);
  const Path path = value_or_throw(Path::make({.spline = Spline::smooth,
                                               .axis_count = static_cast<std::int32_t>(axes),
                                               .keys = at,
                                               .key_frames = frames,
                                               .rests_at_start = rests_at_start,
                                               .rests_at_end = rests_at_end},
                                              {cubics_, weights, knots}));
  for (const FrameKnot& knot : path.knots()) {
    const auto key = static_cast<std::size_t>(knot.key);
    const std::int64_t between = frames[key + 1] - frames[key];
    knots_.push_back(quarters_per_frame * frames[key] +
                     quarters_per_frame * between * knot.part / knot.parts);
  }
  knots_.push_back(quarters_per_frame * frames.back());
  cubics_.resize(knots_.size() * axes);
}

std::size_t FrameSpline::segment_at(std::int64_t quarter) const {
  const auto behind = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, quarter);
  return static_cast<std::size_t>(behind - knots_.begin()) - 1;
}

Cubic FrameSpline::part(std::size_t segment, std::size_t axis, std::int64_t begin, std::int64_t end) const {
  const std::int64_t first = knots_[segment];
  const auto length = static_cast<double>(knots_[segment + 1] - first);
  const Cubic& whole = cubics_[segment * axes_ + axis];
  if (begin == first && end == knots_[segment + 1]) return whole;
  return cut(whole, static_cast<double>(begin - first) / length, static_cast<double>(end - begin) / length);
}

double FrameSpline::value(std::int32_t frame, std::size_t axis) const {
  const std::int64_t quarter = quarters_per_frame * frame;
  if (quarter >= knots_.back()) return end(axis);
  const std::size_t segment = segment_at(quarter);
  return part(segment, axis, quarter, knots_[segment + 1]).c0;
}

Network::Network(const NetworkSpec& spec)
    : spec_(spec),
      axes_(spec.places.size()),
      through_keys_(spec.key_frames, spec.keys, axes_, spec.rests_at_start, spec.rests_at_end),
      drawn_(drawn_curves(spec)),
      knots_(through_keys_.knots().begin(), through_keys_.knots().end()) {
  for (const FrameSpline& curve : drawn_) {
    knots_.insert(knots_.end(), curve.knots().begin(), curve.knots().end());
  }
  std::ranges::sort(knots_);
  knots_.erase(std::unique(knots_.begin(), knots_.end()), knots_.end());
  for (std::size_t axis = 0; axis < axes_; ++axis) shares_.push_back(shares_of(axis));
}

std::optional<NetworkGap> Network::gap() const {
  std::vector<double> allowed;
  for (const NetworkCurve& curve : spec_.curves) {
    auto [low, high] = std::ranges::minmax(curve.at);
    for (std::size_t i = curve.axis; i < spec_.keys.size(); i += axes_) {
      low = std::min(low, spec_.keys[i]);
      high = std::max(high, spec_.keys[i]);
    }
    const double ulp = std::numeric_limits<double>::epsilon() * std::max(std::fabs(low), std::fabs(high));
    allowed.push_back(std::max(closed_share * (high - low), max_gap_ulps * ulp));
  }
  for (std::size_t key = 0; key < spec_.key_frames.size(); ++key) {
    for (std::size_t i = 0; i < drawn_.size(); ++i) {
      const double at_key = spec_.keys[key * axes_ + spec_.curves[i].axis];
      const double drawn = drawn_[i].value(spec_.key_frames[key]);
      if (std::fabs(at_key - drawn) > allowed[i]) return NetworkGap{i, key, at_key, drawn};
    }
  }
  return std::nullopt;
}

/// The mean of what is drawn at a place of the row of an axis, so much of it.
void Network::add_shares_at(std::size_t axis, double place, double weight, std::vector<Share>& shares) const {
  const std::size_t first = shares.size();
  for (std::size_t i = 0; i < spec_.curves.size(); ++i) {
    const NetworkCurve& curve = spec_.curves[i];
    if (is_in_row_of(axis, curve) && spec_.places[curve.axis] == place) shares.push_back({i, weight});
  }
  for (Share& share : std::span(shares).subspan(first))
    share.weight /= static_cast<double>(shares.size() - first);
}

std::vector<Network::Share> Network::shares_of(std::size_t axis) const {
  const double place = spec_.places[axis];
  std::vector<Share> shares;
  // The places next to it at which something is drawn, or the ends of the row, where nothing is added.
  double before = spec_.places.front();
  double behind = spec_.places.back();
  for (const NetworkCurve& curve : spec_.curves) {
    if (!is_in_row_of(axis, curve)) continue;
    const double drawn = spec_.places[curve.axis];
    if (drawn == place) {
      add_shares_at(axis, place, 1, shares);
      return shares;
    }
    if (drawn < place) before = drawn;
    if (drawn > place) behind = std::min(behind, drawn);
  }
  if (place == before || place == behind) return shares;
  const double share = (place - before) / (behind - before);
  add_shares_at(axis, before, 1 - share, shares);
  add_shares_at(axis, behind, share, shares);
  return shares;
}

FrameKnot Network::frame_knot(std::size_t key, std::int64_t begin, std::int64_t end) const {
  const std::int64_t first = quarters_per_frame * spec_.key_frames[key];
  return {.key = static_cast<std::int32_t>(key),
          .part = static_cast<std::int32_t>(begin - first),
          .parts = static_cast<std::int32_t>(quarters_per_frame * spec_.key_frames[key + 1] - first),
          .length = static_cast<std::int32_t>(end - begin)};
}

/// The row of axes on a segment, from each drawn curve there and each axis by its keys alone.
template <class Curve, class Keys>
std::vector<Cubic> Network::row(const Curve& drawn_there, const Keys& keys_there) const {
  std::vector<Cubic> drawn;
  std::vector<Cubic> added;
  for (std::size_t i = 0; i < drawn_.size(); ++i) {
    drawn.push_back(drawn_there(i));
    added.push_back(plus(drawn[i], -1, keys_there(spec_.curves[i].axis)));
  }
  std::vector<Cubic> row;
  row.reserve(axes_);
  for (std::size_t axis = 0; axis < axes_; ++axis) {
    row.push_back(keys_there(axis));
    for (const Share& share : shares_[axis]) row.back() = plus(row.back(), share.weight, added[share.curve]);
  }
  for (std::size_t i = 0; i < drawn_.size(); ++i) row[spec_.curves[i].axis] = drawn[i];
  return row;
}

CubicsOverFrames Network::path() const {
  CubicsOverFrames path;
  path.cubics.reserve(segments() * axes_);
  path.knots.reserve(segments());
  std::vector<std::size_t> segment_of(drawn_.size());  // of each curve
  std::size_t segment_of_keys = 0;
  std::size_t key = 0;
  const auto move_on = [](const FrameSpline& spline, std::int64_t begin, std::size_t& segment) {
    while (spline.knots()[segment + 1] <= begin) ++segment;
  };
  for (std::size_t k = 0; k < segments(); ++k) {
    const std::int64_t begin = knots_[k];
    const std::int64_t end = knots_[k + 1];
    while (quarters_per_frame * spec_.key_frames[key + 1] <= begin) ++key;
    move_on(through_keys_, begin, segment_of_keys);
    for (std::size_t i = 0; i < drawn_.size(); ++i) move_on(drawn_[i], begin, segment_of[i]);
    const std::vector<Cubic> cubics =
        row([&](std::size_t i) { return drawn_[i].part(segment_of[i], 0, begin, end); },
            [&](std::size_t axis) { return through_keys_.part(segment_of_keys, axis, begin, end); });
    path.cubics.insert(path.cubics.end(), cubics.begin(), cubics.end());
    path.knots.push_back(frame_knot(key, begin, end));
  }
  if (spec_.rests_at_end) rest_at_end(path);
  join(path);
  return path;
}

/// What is added up may cancel, and then its rounding is large beside what is left: the core would not
/// believe that two such cubics join.
void Network::join(CubicsOverFrames& path) const {
  for (std::size_t i = 0; i + axes_ < path.cubics.size(); ++i) {
    path.cubics[i].c3 += path.cubics[i + axes_].c0 - path.cubics[i].value(1);
  }
}

/// What rests is at E - p (1 - t)^3 on its last segment. Rounding has left something of a velocity, which
/// would ask for a post-roll.
void Network::rest_at_end(CubicsOverFrames& path) const {
  const std::vector<Cubic> ends = row([&](std::size_t i) { return Cubic{drawn_[i].end(0)}; },
                                      [&](std::size_t axis) { return Cubic{through_keys_.end(axis)}; });
  for (std::size_t axis = 0; axis < axes_; ++axis) {
    Cubic& last = path.cubics[path.cubics.size() - axes_ + axis];
    const double p = last.c3;
    last = {ends[axis].c0 - p, 3 * p, -3 * p, p};
  }
}

}  // namespace inbetween
