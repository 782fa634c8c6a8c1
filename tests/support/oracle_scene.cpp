#include "tests/support/oracle_scene.hpp"

#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <locale>
#include <sstream>
#include <stdexcept>
#include <tuple>

namespace inbetween {
namespace {

using Quad = std::array<double, 4>;  // x, y, z, w

void must_be(bool is_so, const std::string& what) {
  if (!is_so) throw std::runtime_error(what);
}

Quad unit(Quad q) {
  const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& number : q) number /= size;
  return q;
}

/// The image of a vector: v + 2w (u x v) + 2 u x (u x v).
std::array<double, 3> turned(const Quad& q, const std::array<double, 3>& v) {
  const auto cross = [&](const std::array<double, 3>& b) {
    return std::array<double, 3>{q[1] * b[2] - q[2] * b[1], q[2] * b[0] - q[0] * b[2],
                                 q[0] * b[1] - q[1] * b[0]};
  };
  const std::array<double, 3> once = cross(v), twice = cross(once);
  std::array<double, 3> out{};
  for (std::size_t i = 0; i < 3; ++i) out[i] = v[i] + 2 * q[3] * once[i] + 2 * twice[i];
  return out;
}

OraclePose pose_of(const Quad& q, const std::array<double, 3>& position) {
  OraclePose pose;
  pose.position = position;
  for (std::size_t i = 0; i < 3; ++i) {
    std::array<double, 3> axis{};
    axis[i] = 1;
    pose.columns[i] = turned(unit(q), axis);
  }
  return pose;
}

Quad turn_between(const Quad& a, Quad b, double share) {
  double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  if (cosine < 0) {
    cosine = -cosine;
    for (double& number : b) number = -number;
  }
  const double angle = std::acos(std::min(1.0, cosine));
  const double sine = std::sin(angle);
  const double of_a = sine < 1e-9 ? 1 - share : std::sin((1 - share) * angle) / sine;
  const double of_b = sine < 1e-9 ? share : std::sin(share * angle) / sine;
  Quad out{};
  for (std::size_t i = 0; i < 4; ++i) out[i] = of_a * a[i] + of_b * b[i];
  return unit(out);
}

/// The values on either side of a time, and how far it is from the first to the second.
template <class Values>
auto interpolated(const std::map<double, Values>& samples, double time) {
  const auto after = samples.lower_bound(time);
  if (after == samples.end()) return std::tuple(samples.rbegin()->second, samples.rbegin()->second, 0.0);
  if (after->first == time || after == samples.begin()) return std::tuple(after->second, after->second, 0.0);
  const auto before = std::prev(after);
  return std::tuple(before->second, after->second, (time - before->first) / (after->first - before->first));
}

std::vector<double> value_at(const std::map<double, std::vector<double>>& samples, double time,
                             bool is_turn) {
  const auto [a, b, share] = interpolated(samples, time);
  if (is_turn) {
    const Quad turn = turn_between({a[0], a[1], a[2], a[3]}, {b[0], b[1], b[2], b[3]}, share);
    return {turn[0], turn[1], turn[2], turn[3]};
  }
  std::vector<double> out;
  for (std::size_t i = 0; i < a.size(); ++i) out.push_back((1 - share) * a[i] + share * b[i]);
  return out;
}

/// All numbers of a text, whatever stands between them.
std::vector<double> numbers_of(std::string text) {
  for (char& c : text)
    if (c == '(' || c == ')' || c == ',' || c == '[' || c == ']') c = ' ';
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  std::vector<double> numbers;
  for (double number = 0; in >> number;) numbers.push_back(number);
  must_be(in.eof(), "no numbers: " + text);
  return numbers;
}

std::string without_blanks(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string::npos) return "";
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

std::string without_quotes(const std::string& text) {
  return text.size() >= 2 && text.front() == '"' && text.back() == '"' ? text.substr(1, text.size() - 2)
                                                                       : text;
}

}  // namespace

OraclePose combined(const OraclePose& outer, const OraclePose& inner) {
  const auto rotated = [&](const std::array<double, 3>& v) {
    std::array<double, 3> out{};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) out[i] += outer.columns[j][i] * v[j];
    return out;
  };
  OraclePose pose;
  pose.position = rotated(inner.position);
  for (std::size_t i = 0; i < 3; ++i) {
    pose.position[i] += outer.position[i];
    pose.columns[i] = rotated(inner.columns[i]);
  }
  return pose;
}

struct OracleGltf::Model {
  tinygltf::Model model;
  std::vector<int> parents = {};
  std::vector<std::map<double, std::vector<double>>> turns = {}, places = {};  // of each node, by time

  void read_channels() {
    turns.resize(model.nodes.size());
    places.resize(model.nodes.size());
    for (const tinygltf::AnimationChannel& channel : model.animations.at(0).channels) {
      const auto& sampler = model.animations.at(0).samplers.at(static_cast<std::size_t>(channel.sampler));
      must_be(sampler.interpolation == "LINEAR", "interpolated on lines");
      const auto times = rows(sampler.input), values = rows(sampler.output);
      auto& samples = (channel.target_path == "rotation" ? turns : places)
                          .at(static_cast<std::size_t>(channel.target_node));
      for (std::size_t row = 0; row < times.size(); ++row) samples[times[row][0]] = values.at(row);
    }
  }

  [[nodiscard]] std::vector<std::vector<double>> rows(int index) const {
    const tinygltf::Accessor& accessor = model.accessors.at(static_cast<std::size_t>(index));
    const tinygltf::BufferView& view = model.bufferViews.at(static_cast<std::size_t>(accessor.bufferView));
    const std::vector<unsigned char>& bytes = model.buffers.at(static_cast<std::size_t>(view.buffer)).data;
    must_be(accessor.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT, "numbers are floats");
    const auto width =
        static_cast<std::size_t>(tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)));
    const auto stride = static_cast<std::size_t>(accessor.ByteStride(view));
    std::vector<std::vector<double>> rows;
    for (std::size_t row = 0; row < accessor.count; ++row) {
      std::vector<double>& numbers = rows.emplace_back();
      for (std::size_t i = 0; i < width; ++i) {
        float number = 0;
        std::memcpy(&number, &bytes.at(view.byteOffset + accessor.byteOffset + row * stride + 4 * i), 4);
        numbers.push_back(number);
      }
    }
    return rows;
  }
};

OracleGltf::OracleGltf(const std::string& bytes) : model_(std::make_unique<Model>()) {
  tinygltf::TinyGLTF reader;
  std::string error, warning;
  const auto size = static_cast<unsigned int>(bytes.size());
  const bool is_read =
      bytes.starts_with("{")
          ? reader.LoadASCIIFromString(&model_->model, &error, &warning, bytes.data(), size, "")
          : reader.LoadBinaryFromMemory(&model_->model, &error, &warning,
                                        reinterpret_cast<const unsigned char*>(bytes.data()), size);
  must_be(is_read && error.empty() && warning.empty(), "tinygltf: " + error + warning);
  model_->parents.resize(model_->model.nodes.size(), -1);
  model_->read_channels();
  for (std::size_t i = 0; i < model_->model.nodes.size(); ++i)
    for (const int child : model_->model.nodes[i].children)
      model_->parents.at(static_cast<std::size_t>(child)) = static_cast<int>(i);
}

OracleGltf::~OracleGltf() = default;

std::vector<double> OracleGltf::times() const {
  std::vector<double> times;
  for (const auto& row : model_->rows(model_->model.animations.at(0).samplers.at(0).input))
    times.push_back(row[0]);
  return times;
}

OraclePose OracleGltf::pose(const std::string& name, double seconds) const {
  const tinygltf::Model& model = model_->model;
  const auto found = std::find_if(model.nodes.begin(), model.nodes.end(),
                                  [&](const tinygltf::Node& node) { return node.name == name; });
  must_be(found != model.nodes.end(), "no node " + name);
  OraclePose pose = pose_of({0, 0, 0, 1}, {});
  for (int at = static_cast<int>(found - model.nodes.begin()); at >= 0;
       at = model_->parents.at(static_cast<std::size_t>(at))) {
    const tinygltf::Node& node = model.nodes.at(static_cast<std::size_t>(at));
    std::vector<double> turn = node.rotation.empty() ? std::vector<double>{0, 0, 0, 1} : node.rotation;
    std::vector<double> place = node.translation.empty() ? std::vector<double>{0, 0, 0} : node.translation;
    const auto& turns = model_->turns.at(static_cast<std::size_t>(at));
    const auto& places = model_->places.at(static_cast<std::size_t>(at));
    if (!turns.empty()) turn = value_at(turns, seconds, true);
    if (!places.empty()) place = value_at(places, seconds, false);
    pose = combined(pose_of({turn[0], turn[1], turn[2], turn[3]}, {place[0], place[1], place[2]}), pose);
  }
  return pose;
}

std::string OracleGltf::camera_node() const {
  for (const tinygltf::Node& node : model_->model.nodes)
    if (node.camera == 0) return node.name;
  throw std::runtime_error("no node has the camera");
}
double OracleGltf::vertical_angle() const {
  return model_->model.cameras.at(0).perspective.yfov;
}
double OracleGltf::aspect() const {
  return model_->model.cameras.at(0).perspective.aspectRatio;
}

OracleUsd::OracleUsd(const std::string& text) {
  std::istringstream lines(text);
  std::string line, sampled;
  std::getline(lines, line);
  must_be(line.starts_with("#usda 1.0"), "no head");
  std::vector<int> open;  // the prims whose braces are open
  bool is_in_layer = false;
  int lists = 0;  // braces of dictionaries and of samples
  while (std::getline(lines, line)) {
    const std::string words = without_blanks(line);
    if (words.empty()) continue;
    if (words == "(") {
      is_in_layer = true;
    } else if (words == ")") {
      is_in_layer = false;
    } else if (words.starts_with("def ")) {
      std::istringstream in(words);
      std::string def, type, name;
      in >> def >> type >> name;
      prims_.push_back(
          {.type = type, .name = without_quotes(name), .parent = open.empty() ? -1 : open.back()});
    } else if (words == "{") {
      open.push_back(static_cast<int>(prims_.size()) - 1);
    } else if (words == "}" && lists > 0) {
      --lists;
    } else if (words == "}") {
      must_be(!open.empty(), "a brace too many");
      open.pop_back();
    } else if (words.ends_with("{")) {
      ++lists;
      sampled = without_blanks(words.substr(0, words.find('=')));
    } else if (lists > 0 && !is_in_layer) {
      const std::size_t colon = words.find(':');
      auto& samples = prims_.at(static_cast<std::size_t>(open.back())).samples[sampled];
      std::vector<double> numbers = numbers_of(words.substr(colon + 1));
      // A quaternion has its real part first.
      if (sampled.starts_with("quatd")) std::rotate(numbers.begin(), numbers.begin() + 1, numbers.end());
      samples[std::stod(words.substr(0, colon))] = numbers;
    } else {
      const std::size_t equals = words.find('=');
      must_be(equals != std::string::npos, "what is this: " + words);
      auto& to = is_in_layer ? layer_ : prims_.at(static_cast<std::size_t>(open.back())).attributes;
      std::string key = without_blanks(words.substr(0, equals));
      key = key.substr(key.rfind(' ') == std::string::npos ? 0 : key.rfind(' ') + 1);
      to[key] = without_quotes(without_blanks(words.substr(equals + 1)));
    }
  }
  must_be(open.empty() && lists == 0, "a brace is open");
}

std::string OracleUsd::layer(const std::string& key) const {
  return layer_.at(key);
}

const OracleUsd::Prim& OracleUsd::prim(const std::string& name) const {
  for (const Prim& prim : prims_)
    if (prim.name == name) return prim;
  throw std::runtime_error("no prim " + name);
}

std::string OracleUsd::attribute(const std::string& name, const std::string& attribute) const {
  return prim(name).attributes.at(attribute);
}

std::string OracleUsd::prim_of_type(const std::string& type) const {
  for (const Prim& prim : prims_)
    if (prim.type == type) return prim.name;
  throw std::runtime_error("no prim of type " + type);
}

OracleLens OracleUsd::lens() const {
  const std::string camera = prim_of_type("Camera");
  const double metres = std::stod(layer("metersPerUnit"));
  const auto number = [&](const char* name) { return std::stod(attribute(camera, name)); };
  const double mm = metres * 1000 / 10;  // of a tenth of a unit
  return {number("focalLength") * mm, number("horizontalAperture") * mm, number("verticalAperture") * mm,
          number("focusDistance") * metres};
}

OraclePose OracleUsd::pose(const std::string& name, double time_code) const {
  OraclePose pose = pose_of({0, 0, 0, 1}, {});
  for (const Prim* at = &prim(name); at != nullptr;
       at = at->parent < 0 ? nullptr : &prims_[static_cast<std::size_t>(at->parent)]) {
    const auto value = [&](const std::string& op, const std::string& type, std::vector<double> rest) {
      const auto samples = at->samples.find(type + " " + op + ".timeSamples");
      if (samples != at->samples.end()) return value_at(samples->second, time_code, type == "quatd");
      const auto still = at->attributes.find(op);
      if (still == at->attributes.end()) return rest;
      std::vector<double> numbers = numbers_of(still->second);
      if (type == "quatd") std::rotate(numbers.begin(), numbers.begin() + 1, numbers.end());
      return numbers;
    };
    const auto turn = value("xformOp:orient", "quatd", {0, 0, 0, 1});
    const auto place = value("xformOp:translate", "double3", {0, 0, 0});
    pose = combined(pose_of({turn[0], turn[1], turn[2], turn[3]}, {place[0], place[1], place[2]}), pose);
  }
  return pose;
}

}  // namespace inbetween
