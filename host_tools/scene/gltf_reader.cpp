#include "host_tools/scene/gltf_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <utility>

#include "host_tools/exchange/placed_json.hpp"
#include "host_tools/exchange/table_words.hpp"
#include "host_tools/scene/base64.hpp"
#include "host_tools/scene/scene_bounds.hpp"

namespace inbetween {
namespace {

constexpr std::int64_t max_offset = std::numeric_limits<std::int32_t>::max();

struct GltfParts {
  std::string_view json, numbers;
};

std::uint32_t u32_at(std::string_view bytes, std::size_t at) {
  std::uint32_t number = 0;
  for (std::size_t i = 4; i-- > 0;) number = number << 8U | static_cast<unsigned char>(bytes[at + i]);
  return number;
}

GltfParts parts_of(std::string_view bytes, const std::string& file) {
  if (!bytes.starts_with("glTF")) return {bytes, {}};
  constexpr std::size_t header = 12, chunk_header = 8;
  const auto refuse = [&](const char* what) {
    throw InputError({file}, fmt::format("{}; write the file again", what));
  };
  if (bytes.size() < header + chunk_header) refuse("this binary glTF ends before its first chunk");
  if (u32_at(bytes, 4) != 2) refuse("this binary glTF is not of version 2");
  GltfParts parts;
  for (std::size_t at = header; at + chunk_header <= bytes.size();) {
    const std::size_t length = u32_at(bytes, at);
    const std::string_view kind = bytes.substr(at + 4, 4);
    at += chunk_header;
    if (length > bytes.size() - at) refuse("a chunk of this binary glTF goes beyond the end of the file");
    if (kind == "JSON" && parts.json.empty()) parts.json = bytes.substr(at, length);
    if (kind == std::string_view("BIN\0", 4) && parts.numbers.empty())
      parts.numbers = bytes.substr(at, length);
    at += length;
  }
  if (parts.json.empty()) refuse("this binary glTF has no chunk of JSON");
  return parts;
}

/// "A%20b" as a path, in the folder of the scene.
std::string path_of_uri(const JsonValue& uri) {
  const std::string& text = uri.text("uri");
  std::string path;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto digit = [&](std::size_t at) {
      const std::size_t value =
          std::string_view("0123456789abcdef")
              .find(at < text.size() ? static_cast<char>(std::tolower(static_cast<unsigned char>(text[at])))
                                     : '?');
      return value == std::string_view::npos ? 16 : static_cast<unsigned>(value);
    };
    const bool is_coded = text[i] == '%' && digit(i + 1) < 16 && digit(i + 2) < 16;
    path += is_coded ? static_cast<char>(digit(i + 1) * 16 + digit(i + 2)) : text[i];
    if (is_coded) i += 2;
  }
  const std::filesystem::path as_path(path);
  const bool leaves = std::ranges::any_of(as_path, [](const auto& part) { return part == ".."; });
  if (as_path.is_absolute() || leaves || path.find('\0') != std::string::npos ||
      path.find("://") != std::string::npos)
    uri.refuse("this file is not in the folder of the scene; put it there, or write one .glb file");
  return path;
}

class GltfReader {
 public:
  GltfReader(std::string_view bytes, const std::string& file, const TextReader& read)
      : parts_(parts_of(bytes, file)),
        read_(read),
        document_(parts_.json, file, {.bytes = max_gltf_json_bytes, .nesting = max_scene_depth}) {
    scene_.file = file;
  }

  SceneFile scene() {
    const JsonValue root = document_.root();
    const JsonValue asset = root.required("asset", "\"asset\": { \"version\": \"2.0\" }");
    const JsonValue version = asset.required("version", "\"version\": \"2.0\"");
    if (!version.text("version").starts_with("2."))
      version.refuse("only glTF 2 is read; write the file again as glTF 2.0");
    take_extras(asset);
    nodes_ = items_of(root, "nodes", max_scene_nodes);
    buffers_.resize(items_of(root, "buffers", max_scene_nodes).size());
    buffer_values_ = items_of(root, "buffers", max_scene_nodes);
    views_ = items_of(root, "bufferViews", max_scene_samples);
    accessors_ = items_of(root, "accessors", max_scene_samples);
    find_parents();
    take_animations(root);
    order_nodes();
    return std::move(scene_);
  }

 private:
  struct Channels {
    std::optional<SceneOp> translation, rotation, scale;
  };

  static std::vector<JsonValue> items_of(const JsonValue& value, std::string_view key, std::size_t max) {
    const std::optional<JsonValue> found = value.find(key);
    if (!found) return {};
    if (found->kind() != JsonKind::array) found->refuse(fmt::format("{} is no list; write [ ]", key));
    std::vector<JsonValue> items = found->items();
    if (items.size() > max) found->refuse(fmt::format("there are more than {}; write a smaller scene", max));
    return items;
  }

  static std::size_t index_of(const JsonValue& value, std::string_view what, std::size_t count) {
    if (count == 0) value.refuse(fmt::format("there is no {} in the file; write it again", what));
    return static_cast<std::size_t>(value.whole_number(what, 0, static_cast<std::int64_t>(count) - 1));
  }

  void take_extras(const JsonValue& asset) {
    const auto extras = asset.find("extras");
    const auto ours = extras ? extras->find("inbetween") : std::nullopt;
    if (!ours) return;
    if (const auto fps = ours->find("frames_per_second")) {
      scene_.fps = frame_rate_of_word(fps->text("frames_per_second"));
      if (!scene_.fps) fps->refuse("this is no exact rate; write \"24\" or \"24000/1001\"");
    }
    if (const auto first = ours->find("first_frame"))
      scene_.first_frame = first->whole_number("first_frame", -max_table_frame, max_table_frame);
  }

  void find_parents() {
    parents_.assign(nodes_.size(), -1);
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      for (const JsonValue& child : items_of(nodes_[i], "children", nodes_.size())) {
        const std::size_t index = index_of(child, "node", nodes_.size());
        if (parents_[index] >= 0 || index == i) child.refuse("this node hangs on two; let it hang on one");
        parents_[index] = static_cast<std::int32_t>(i);
      }
    }
  }

  // --- numbers

  const std::string_view& buffer(std::size_t index) {
    std::optional<std::string>& kept = buffers_[index];
    if (!kept) {
      const std::optional<JsonValue> uri = buffer_values_[index].find("uri");
      constexpr std::string_view data = "data:", base64 = ";base64,";
      if (!uri) {
        if (index != 0 || parts_.numbers.empty())
          buffer_values_[index].refuse("this buffer has no uri; write the file again");
        kept = std::string(parts_.numbers);
      } else if (uri->text("uri").starts_with(data)) {
        const std::string& text = uri->text("uri");
        const std::size_t begin = text.find(base64);
        if (begin == std::string::npos) uri->refuse("these data are not in base64; write the file again");
        kept = bytes_of_base64(std::string_view(text).substr(begin + base64.size()));
        if (!kept) uri->refuse("this is no base64; write the file again");
      } else {
        const auto folder = std::filesystem::path(scene_.file).parent_path();
        kept = read_(folder / path_of_uri(*uri), max_gltf_bytes);
      }
    }
    view_ = *kept;
    return view_;
  }

  /// An accessor as numbers, `width` a value.
  std::vector<double> numbers(const JsonValue& index, std::string_view type, std::size_t width) {
    const JsonValue accessor = accessors_[index_of(index, "accessor", accessors_.size())];
    if (accessor.find("sparse")) accessor.refuse("sparse numbers are not read; write the file without");
    const JsonValue kind = accessor.required("type", "\"type\": \"VEC3\"");
    if (kind.text("type") != type) kind.refuse(fmt::format("it must be {} here; write the file again", type));
    const auto count =
        static_cast<std::size_t>(accessor.required("count", "\"count\": 2")
                                     .whole_number("count", 1, static_cast<std::int64_t>(max_scene_samples)));
    samples_ += count * width;
    if (samples_ > max_scene_samples)
      accessor.refuse(
          fmt::format("the scene moves with more than {} numbers; write a smaller one", max_scene_samples));
    const JsonValue view =
        views_[index_of(accessor.required("bufferView", "\"bufferView\": 0"), "bufferView", views_.size())];
    if (view.find("extensions"))
      view.refuse("these numbers are packed (meshopt); write the file without compression");
    const JsonValue component = accessor.required("componentType", "\"componentType\": 5126");
    const auto component_type = component.whole_number("componentType", 0, max_offset);
    const std::size_t size = component_type == 5126                             ? 4
                             : component_type == 5122 || component_type == 5123 ? 2
                                                                                : 1;
    if (component_type != 5126 && (component_type < 5120 || component_type > 5123))
      component.refuse("only floats, bytes and shorts are read here; write floats (5126)");
    const auto offset_of = [](const JsonValue& value, std::string_view key) {
      const auto found = value.find(key);
      return found ? static_cast<std::size_t>(found->whole_number(key, 0, max_offset)) : 0;
    };
    const std::size_t stride = std::max(offset_of(view, "byteStride"), width * size);
    const std::string_view bytes =
        buffer(index_of(view.required("buffer", "\"buffer\": 0"), "buffer", buffers_.size()));
    const std::size_t begin = offset_of(view, "byteOffset") + offset_of(accessor, "byteOffset");
    const std::size_t end = begin + (count - 1) * stride + width * size;
    if (end > bytes.size())
      accessor.refuse("these numbers go beyond the end of their buffer; write the file again");
    std::vector<double> values;
    values.reserve(count * width);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < width; ++j)
        values.push_back(number_at(bytes.data() + begin + i * stride + j * size, component_type, accessor));
    return values;
  }

  /// Whole numbers are shares of 1 (glTF 2.0, 3.6.2.2).
  static double number_at(const char* at, std::int64_t type, const JsonValue& accessor) {
    constexpr double of_byte = 127, of_unsigned_byte = 255, of_short = 32'767, of_unsigned_short = 65'535;
    if (type == 5120) return std::max(-1.0, static_cast<signed char>(*at) / of_byte);
    if (type == 5121) return static_cast<unsigned char>(*at) / of_unsigned_byte;
    std::uint32_t bits = 0;
    std::memcpy(&bits, at, type == 5126 ? 4 : 2);
    if (type == 5122) return std::max(-1.0, static_cast<std::int16_t>(bits) / of_short);
    if (type == 5123) return bits / of_unsigned_short;
    const auto number = static_cast<double>(std::bit_cast<float>(bits));
    if (!(std::fabs(number) <= max_scene_number))
      accessor.refuse(
          fmt::format("one of these numbers is {}; write finite ones up to {:g}", number, max_scene_number));
    return number;
  }

  // --- motion

  void take_animations(const JsonValue& root) {
    channels_.resize(nodes_.size());
    for (const JsonValue& animation : items_of(root, "animations", max_scene_nodes)) {
      const std::vector<JsonValue> samplers = items_of(animation, "samplers", max_scene_samples);
      for (const JsonValue& channel : items_of(animation, "channels", max_scene_samples))
        take_channel(channel, samplers);
    }
  }

  void take_channel(const JsonValue& channel, const std::vector<JsonValue>& samplers) {
    const JsonValue target =
        channel.required("target", "\"target\": { \"node\": 0, \"path\": \"rotation\" }");
    const std::optional<JsonValue> node = target.find("node");
    const std::string& path = target.required("path", "\"path\": \"rotation\"").text("path");
    if (!node || (path != "translation" && path != "rotation" && path != "scale"))
      return;  // of no node's place
    Channels& of_node = channels_[index_of(*node, "node", nodes_.size())];
    std::optional<SceneOp>& op = path == "translation" ? of_node.translation
                                 : path == "rotation"  ? of_node.rotation
                                                       : of_node.scale;
    if (op) channel.refuse(fmt::format("a second animation has the {} of this node; keep one of them", path));
    op.emplace();
    op->kind = path == "translation" ? SceneOpKind::translate
               : path == "rotation"  ? SceneOpKind::quaternion
                                     : SceneOpKind::scale;
    const JsonValue sampler =
        samplers[index_of(channel.required("sampler", "\"sampler\": 0"), "sampler", samplers.size())];
    if (const auto curve = sampler.find("interpolation")) {
      const std::string& word = curve->text("interpolation");
      if (word != "LINEAR" && word != "STEP" && word != "CUBICSPLINE")
        curve->refuse("this is no interpolation; write LINEAR, STEP or CUBICSPLINE");
      op->curve = word == "STEP"          ? SceneCurve::step
                  : word == "CUBICSPLINE" ? SceneCurve::cubic
                                          : SceneCurve::linear;
    }
    op->times = numbers(sampler.required("input", "\"input\": 0"), "SCALAR", 1);
    const std::size_t width = width_of(*op);
    op->values = numbers(sampler.required("output", "\"output\": 1"), width == 4 ? "VEC4" : "VEC3", width);
    const std::size_t wanted = op->times.size() * width * (op->curve == SceneCurve::cubic ? 3 : 1);
    if (op->values.size() != wanted)
      sampler.refuse("it has not as many values as times; write the file again");
    if (std::ranges::adjacent_find(op->times, std::greater_equal<>()) != op->times.end())
      sampler.refuse("its times do not ascend; write the file again");
    if (!has_directions(*op))
      sampler.refuse("one of these rotations is 0, and turns nowhere; write the file again");
  }

  // --- nodes

  [[noreturn]] static void refuse_depth(const JsonValue& node) {
    node.refuse(
        fmt::format("this node hangs deeper than {} below others, or in a circle; write a flatter scene",
                    max_scene_depth));
  }

  /// Parents before children.
  void order_nodes() {
    std::vector<std::int32_t> place(nodes_.size(), -1);
    for (std::int32_t i = 0; i < std::ssize(nodes_); ++i) {
      std::vector<std::size_t> chain;
      for (std::int32_t at = i; at >= 0 && place[static_cast<std::size_t>(at)] < 0;
           at = parents_[static_cast<std::size_t>(at)]) {
        chain.push_back(static_cast<std::size_t>(at));
        if (chain.size() > max_scene_depth) refuse_depth(nodes_[static_cast<std::size_t>(i)]);
      }
      std::ranges::reverse(chain);
      for (const std::size_t node : chain) {
        place[node] = static_cast<std::int32_t>(scene_.nodes.size());
        const std::int32_t parent = parents_[node];
        add_node(node, parent < 0 ? -1 : place[static_cast<std::size_t>(parent)]);
      }
    }
  }

  void add_node(std::size_t index, std::int32_t parent) {
    const JsonValue& value = nodes_[index];
    FileNode node{.name = fmt::format("node {}", index), .parent = parent, .place = value.place()};
    if (parent >= 0) node.depth = scene_.nodes[static_cast<std::size_t>(parent)].depth + 1;
    if (node.depth > max_scene_depth) refuse_depth(value);
    if (const auto name = value.find("name"); name && !name->text("name").empty())
      node.name = name->text("name");
    node.is_camera = value.find("camera").has_value();
    Channels& moved = channels_[index];
    if (const auto matrix = value.find("matrix")) {
      if (moved.translation || moved.rotation || moved.scale)
        matrix->refuse("a node that moves has no matrix; write translation, rotation and scale");
      node.ops.push_back(still(*matrix, SceneOpKind::matrix));
    } else {
      add_op(value, "translation", SceneOpKind::translate, moved.translation, node);
      add_op(value, "rotation", SceneOpKind::quaternion, moved.rotation, node);
      add_op(value, "scale", SceneOpKind::scale, moved.scale, node);
    }
    scene_.nodes.push_back(std::move(node));
  }

  static void add_op(const JsonValue& node, std::string_view key, SceneOpKind kind,
                     std::optional<SceneOp>& moved, FileNode& to) {
    if (moved) {
      to.ops.push_back(std::move(*moved));
    } else if (const auto value = node.find(key)) {
      to.ops.push_back(still(*value, kind));
    }
  }

  static SceneOp still(const JsonValue& value, SceneOpKind kind) {
    SceneOp op{.kind = kind};
    const std::vector<JsonValue> items =
        value.kind() == JsonKind::array ? value.items() : std::vector<JsonValue>{};
    if (items.size() != width_of(op))
      value.refuse(fmt::format("this is no list of {} numbers; write the file again", width_of(op)));
    for (const JsonValue& item : items) {
      const double number = item.number("a number of it");
      if (!(std::fabs(number) <= max_scene_number))
        item.refuse(fmt::format("this is beyond {:g}; write a smaller number", max_scene_number));
      op.values.push_back(number);
    }
    if (!has_directions(op)) value.refuse("this rotation is 0, and turns nowhere; write the file again");
    return op;
  }

  GltfParts parts_;
  const TextReader& read_;
  PlacedJson document_;
  SceneFile scene_;
  std::vector<JsonValue> nodes_, buffer_values_, views_, accessors_;
  std::vector<std::optional<std::string>> buffers_;
  std::string_view view_;
  std::vector<std::int32_t> parents_;
  std::vector<Channels> channels_;
  std::size_t samples_ = 0;
};

}  // namespace

SceneFile read_gltf(std::string_view bytes, const std::string& file, const TextReader& read) {
  if (bytes.size() > max_gltf_bytes)
    throw InputError({file}, fmt::format("the file has {} bytes; write a scene of at most {}", bytes.size(),
                                         max_gltf_bytes));
  return GltfReader(bytes, file, read).scene();
}

}  // namespace inbetween
