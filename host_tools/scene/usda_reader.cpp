#include "host_tools/scene/usda_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "host_tools/exchange/table_words.hpp"
#include "host_tools/scene/scene_bounds.hpp"
#include "host_tools/scene/usda_words.hpp"
#include "host_tools/text/text_file.hpp"

namespace inbetween {
namespace {

constexpr std::string_view op_prefix = "xformOp:";

double number_of(const UsdaWords& words, const UsdaWord& word) {
  const std::string_view letters = word.letters.starts_with('+') ? word.letters.substr(1) : word.letters;
  double number = 0;
  const auto [end, error] = std::from_chars(letters.data(), letters.data() + letters.size(), number);
  const bool is_whole =
      word.kind == UsdaKind::number && error == std::errc() && end == letters.data() + letters.size();
  if (!is_whole || !(std::fabs(number) <= max_scene_number)) {
    words.refuse(word, fmt::format("{} is no number of up to {:g}; write one such as 12.5",
                                   in_quotes(word.letters), max_scene_number));
  }
  return number;
}

/// "(1, (2, 3))" as 1 2 3; a number alone as itself.
std::vector<double> numbers_of(UsdaWords& words, std::size_t count) {
  const UsdaWord begin = words.peek();
  std::vector<double> numbers;
  std::size_t open = 0;
  do {
    if (words.take_if("(")) {
      if (++open > 2) words.refuse(begin, "this nests deeper than a matrix; write the file again");
      continue;
    }
    if (words.take_if(")")) {
      if (open == 0) words.refuse(begin, "no bracket is open here; write the file again");
      --open;
      continue;
    }
    if (open > 0 && words.take_if(",")) continue;
    if (numbers.size() == count)
      words.refuse(begin, fmt::format("this has more than {} numbers; write the file again", count));
    numbers.push_back(number_of(words, words.take()));
  } while (open > 0);
  if (numbers.size() != count)
    words.refuse(begin, fmt::format("this has {} numbers in place of {}; write the file again",
                                    numbers.size(), count));
  return numbers;
}

/// What an op is, by its name: "translate", "rotateXYZ", "orient".
std::optional<SceneOp> op_of(std::string_view kind) {
  if (kind == "translate") return SceneOp{.kind = SceneOpKind::translate};
  if (kind == "scale") return SceneOp{.kind = SceneOpKind::scale};
  if (kind == "orient") return SceneOp{.kind = SceneOpKind::quaternion};
  if (kind == "transform") return SceneOp{.kind = SceneOpKind::matrix};
  constexpr std::string_view rotate = "rotate";
  if (!kind.starts_with(rotate)) return std::nullopt;
  std::string axes;
  for (const char axis : kind.substr(rotate.size())) {
    if (axis < 'X' || axis > 'Z' || axes.find(static_cast<char>(axis - 'X' + 'x')) != std::string::npos)
      return std::nullopt;
    axes += static_cast<char>(axis - 'X' + 'x');
  }
  if (axes.size() != 1 && axes.size() != 3) return std::nullopt;
  return SceneOp{.kind = SceneOpKind::angles, .axes = axes};
}

/// The numbers of a value as SceneOp has them.
std::vector<double> in_order_of_op(const SceneOp& op, std::vector<double> numbers) {
  if (op.kind == SceneOpKind::quaternion) {
    std::rotate(numbers.begin(), numbers.begin() + 1, numbers.end());  // the real part stands first in a file
  } else if (op.kind == SceneOpKind::angles && op.axes.size() == 3) {
    // A file has the angles about x, y and z, whatever the order of turning is.
    const std::vector<double> about = numbers;
    for (std::size_t i = 0; i < 3; ++i) numbers[i] = about[static_cast<std::size_t>(op.axes[i] - 'x')];
  }
  return numbers;  // a matrix has its rows in a file, on which a point stands at the left: our columns
}

class UsdaReader {
 public:
  UsdaReader(std::string_view text, const std::string& file) : words_(text, file) { scene_.file = file; }

  SceneFile scene() {
    // What the stage has where its file says nothing (UsdGeom): hundredths of a metre, y up, 24 a second.
    scene_.metres_per_unit = 0.01;
    scene_.codes_per_second = 24;
    scene_.has_frames = true;
    if (words_.take_if("(")) read_layer();
    while (words_.peek().kind != UsdaKind::end) read_spec(-1, 0);
    return std::move(scene_);
  }

 private:
  /// The ops of a prim by their names, before their order is known.
  struct Prim {
    std::map<std::string, SceneOp, std::less<>> ops = {};
    std::vector<std::string> order = {};
    UsdaWord order_at = {};
  };

  void warn_once(const UsdaWord& at, std::string message) {
    const bool is_told =
        std::ranges::find(scene_.warnings, message, &Warning::message) != scene_.warnings.end();
    if (!is_told) scene_.warnings.push_back({words_.place_of(at), std::move(message)});
  }

  // --- the stage

  void read_layer() {
    while (!words_.take_if(")")) {
      const UsdaWord key = words_.take();
      if (key.kind == UsdaKind::end)
        words_.refuse(key, "the text ends within its head; write the file again");
      if (key.kind == UsdaKind::text) continue;  // a comment
      if (key.kind != UsdaKind::name)
        words_.refuse(key, "here a name must stand, such as upAxis; write the file again");
      if (is_list_word(key.letters)) {
        read_list(words_.take());
        continue;
      }
      words_.require("=");
      read_of_layer(key);
    }
  }

  static bool is_list_word(std::string_view word) {
    return word == "prepend" || word == "append" || word == "add" || word == "delete" || word == "reorder";
  }
  void read_list(const UsdaWord& key) {
    if (key.letters == "subLayers" || key.letters == "references" || key.letters == "payload" ||
        key.letters == "inherits" || key.letters == "specializes")
      warn_once(key, fmt::format(
                         "what the file takes from others ({}) is not read; flatten it where it was written",
                         key.letters));
    words_.require("=");
    words_.skip_value();
    if (words_.peek().letters == "(" && words_.peek().kind == UsdaKind::sign) words_.skip_value();
  }

  void read_of_layer(const UsdaWord& key) {
    const std::string_view name = key.letters;
    if (name == "upAxis") {
      const UsdaWord axis = words_.take();
      if (axis.letters != "Y" && axis.letters != "Z") words_.refuse(axis, "up is Y or Z; write one of them");
      scene_.up = axis.letters == "Y" ? UpAxis::y : UpAxis::z;
    } else if (name == "metersPerUnit") {
      scene_.metres_per_unit = above_zero();
    } else if (name == "timeCodesPerSecond") {
      scene_.codes_per_second = above_zero();
      has_codes_per_second_ = true;
    } else if (name == "framesPerSecond") {
      const double rate = above_zero();
      if (!has_codes_per_second_) scene_.codes_per_second = rate;
    } else if (name == "startTimeCode" || name == "endTimeCode") {
      (name.starts_with('s') ? scene_.first : scene_.last) = number_of(words_, words_.take());
    } else if (name == "customLayerData") {
      read_dictionary(false);
    } else if (name == "subLayers") {
      warn_once(key,
                "what the file takes from others (subLayers) is not read; flatten it where it was written");
      words_.skip_value();
    } else {
      words_.skip_value();
    }
  }

  double above_zero() {
    const UsdaWord word = words_.take();
    const double number = number_of(words_, word);
    if (!(number >= 1 / max_scene_number)) words_.refuse(word, "this must be above 0; correct it");
    return number;
  }

  /// Of customLayerData only what the writer of inbetween says: dictionary inbetween = { string
  /// frames_per_second = "24000/1001" }.
  void read_dictionary(bool is_ours) {
    words_.require("{");
    while (!words_.take_if("}")) {
      const UsdaWord type = words_.take();
      if (type.kind == UsdaKind::end)
        words_.refuse(type, "the text ends within a dictionary; write the file again");
      if (words_.take_if("[")) words_.require("]");
      const UsdaWord name = words_.take();
      if (!is_ours && type.letters == "dictionary" && name.letters == "inbetween") {
        words_.require("=");
        read_dictionary(true);
        continue;
      }
      words_.require("=");
      if (!is_ours || name.letters != "frames_per_second") {
        words_.skip_value();
        continue;
      }
      const UsdaWord rate = words_.take();
      scene_.fps = frame_rate_of_word(rate.letters);
      if (!scene_.fps) words_.refuse(rate, "this is no exact rate; write \"24\" or \"24000/1001\"");
    }
  }

  // --- prims

  void read_spec(std::int32_t parent, std::size_t depth) {
    const UsdaWord kind = words_.take();
    if (kind.letters != "def" && kind.letters != "over" && kind.letters != "class") {
      words_.refuse(
          kind, fmt::format("here {} stands, where def, over or class begins a prim; write the file again",
                            in_quotes(kind.letters)));
    }
    if (depth > max_scene_depth)
      words_.refuse(
          kind, fmt::format("this prim is deeper than {} in others; write a flatter scene", max_scene_depth));
    std::string_view type;
    if (words_.peek().kind == UsdaKind::name) type = words_.take().letters;
    const UsdaWord name = words_.take();
    if (name.kind != UsdaKind::text) words_.refuse(name, "a prim has a name in quotes; write one");
    if (words_.take_if("(")) read_prim_data();
    if (scene_.nodes.size() == max_scene_nodes)
      words_.refuse(name,
                    fmt::format("the scene has more than {} prims; write a smaller one", max_scene_nodes));
    const auto index = static_cast<std::int32_t>(scene_.nodes.size());
    scene_.nodes.push_back({.name = std::string(name.letters),
                            .parent = parent,
                            .depth = depth,
                            .is_camera = type == "Camera",
                            .ops = {},
                            .place = words_.place_of(name)});
    words_.require("{");
    Prim prim;
    while (!words_.take_if("}")) read_of_prim(index, depth, prim);
    put_in_order(prim, scene_.nodes[static_cast<std::size_t>(index)]);
  }

  void read_prim_data() {
    while (!words_.take_if(")")) {
      const UsdaWord key = words_.take();
      if (key.kind == UsdaKind::end) words_.refuse(key, "the text ends within a prim; write the file again");
      if (key.kind == UsdaKind::text) continue;
      read_list(is_list_word(key.letters) ? words_.take() : key);
    }
  }

  void read_of_prim(std::int32_t index, std::size_t depth, Prim& prim) {
    const UsdaWord word = words_.peek();
    if (word.kind == UsdaKind::end) words_.refuse(word, "the text ends within a prim; write the file again");
    const bool begins_spec = word.kind == UsdaKind::name &&
                             (word.letters == "def" || word.letters == "over" || word.letters == "class");
    if (begins_spec) {
      read_spec(index, depth + 1);
    } else if (words_.take_if("variantSet")) {
      warn_once(word, "variants are not read; flatten the file where it was written");
      words_.take();
      words_.require("=");
      words_.skip_value();
    } else if (words_.take_if("reorder")) {
      words_.take();
      words_.require("=");
      words_.skip_value();
    } else {
      read_property(prim);
    }
  }

  /// "uniform token[] xformOpOrder = [...]", "double3 xformOp:translate.timeSamples = {...}".
  void read_property(Prim& prim) {
    std::vector<UsdaWord> before;  // its qualities, its type and its name
    while (words_.peek().kind == UsdaKind::name) {
      before.push_back(words_.take());
      if (words_.take_if("[")) words_.require("]");
    }
    constexpr std::size_t fewest = 2;
    if (before.size() < fewest)
      words_.refuse(before.empty() ? words_.take() : before.front(),
                    "a property has a type and a name; write the file again");
    const UsdaWord name = before.back();
    if (words_.take_if("=")) {
      if (name.letters == "xformOpOrder") {
        read_order(prim, name);
      } else if (name.letters.starts_with(op_prefix)) {
        read_op(prim, name);
      } else {
        words_.skip_value();
      }
    }
    if (words_.peek().kind == UsdaKind::sign && words_.peek().letters == "(") words_.skip_value();
  }

  void read_order(Prim& prim, const UsdaWord& name) {
    prim.order_at = name;
    prim.order.clear();
    words_.require("[");
    while (!words_.take_if("]")) {
      if (words_.take_if(",")) continue;
      const UsdaWord op = words_.take();
      if (op.kind != UsdaKind::text) words_.refuse(op, "an op is named in quotes; write the file again");
      if (prim.order.size() == max_scene_depth)
        words_.refuse(op, fmt::format("a prim has more than {} ops; write fewer", max_scene_depth));
      prim.order.emplace_back(op.letters);
    }
  }

  void read_op(Prim& prim, const UsdaWord& name) {
    constexpr std::string_view samples = ".timeSamples";
    const bool is_sampled = name.letters.ends_with(samples);
    const std::string_view whole =
        name.letters.substr(0, name.letters.size() - (is_sampled ? samples.size() : 0));
    if (whole.find('.') != std::string_view::npos) {  // .connect and the like
      words_.skip_value();
      return;
    }
    const std::string_view kind =
        whole.substr(op_prefix.size(), whole.find(':', op_prefix.size()) - op_prefix.size());
    std::optional<SceneOp> op = op_of(kind);
    if (!op)
      words_.refuse(
          name,
          fmt::format("the op {} is not read; write it as translate, rotate, orient, scale or transform",
                      in_quotes(kind)));
    if (words_.take_if("None")) return;
    const auto there = prim.ops.find(whole);
    const bool has_samples = there != prim.ops.end() && !there->second.times.empty();
    if (!is_sampled) {
      op->values = in_order_of_op(*op, numbers_of(words_, width_of(*op)));
      if (has_samples) return;  // samples come first, whatever stands first in the file
    } else {
      read_samples(*op);
      if (op->times.empty()) return;
    }
    if (!has_directions(*op))
      words_.refuse(name, "one of these rotations is 0, and turns nowhere; write the file again");
    prim.ops.insert_or_assign(std::string(whole), std::move(*op));
  }

  void read_samples(SceneOp& op) {
    words_.require("{");
    while (!words_.take_if("}")) {
      if (words_.take_if(",")) continue;
      const UsdaWord at = words_.take();
      const double code = number_of(words_, at);
      if (!op.times.empty() && code <= op.times.back())
        words_.refuse(at, "its time codes do not ascend; write the file again");
      words_.require(":");
      if (words_.take_if("None"))
        words_.refuse(at, "the value ends here (None), and nobody knows what holds; remove it");
      const std::vector<double> value = in_order_of_op(op, numbers_of(words_, width_of(op)));
      samples_ += value.size() + 1;
      if (samples_ > max_scene_samples)
        words_.refuse(at, fmt::format("the scene moves with more than {} numbers; write a smaller one",
                                      max_scene_samples));
      op.times.push_back(code);
      op.values.insert(op.values.end(), value.begin(), value.end());
    }
  }

  void put_in_order(Prim& prim, FileNode& node) {
    constexpr std::string_view inverse = "!invert!", reset = "!resetXformStack!";
    for (const std::string& word : prim.order) {
      if (word == reset) {
        node.parent = -1;
        node.ops.clear();
        continue;
      }
      const bool is_inverse = word.starts_with(inverse);
      const std::string_view name = std::string_view(word).substr(is_inverse ? inverse.size() : 0);
      const auto op = prim.ops.find(name);
      if (op == prim.ops.end()) {
        const bool is_known = name.starts_with(op_prefix);
        if (!is_known)
          words_.refuse(prim.order_at, fmt::format("{} is no op; write the file again", in_quotes(word)));
        continue;  // an op without a value does nothing
      }
      node.ops.push_back(op->second);
      node.ops.back().is_inverse = is_inverse;
    }
  }

  UsdaWords words_;
  SceneFile scene_;
  bool has_codes_per_second_ = false;
  std::size_t samples_ = 0;
};

}  // namespace

SceneFile read_usda(std::string_view text, const std::string& file) {
  if (text.starts_with("PXR-USDC"))
    throw InputError({file}, "this is USD in binary; write it as text (.usda)");
  if (text.starts_with("PK")) throw InputError({file}, "this is USD in an archive; write it as text (.usda)");
  if (text.size() > max_usda_bytes)
    throw InputError({file}, fmt::format("the file has {} bytes; write a scene of at most {}", text.size(),
                                         max_usda_bytes));
  const bool has_mark = text.starts_with(byte_order_mark);
  if (!text.substr(has_mark ? byte_order_mark.size() : 0).starts_with("#usda 1.0"))
    throw InputError({file, 1, 1}, "the text does not begin with #usda 1.0; name a file of USD");
  return UsdaReader(text, file).scene();
}

}  // namespace inbetween
