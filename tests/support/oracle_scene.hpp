// Scenes read by others than the product: glTF by tinygltf, and USD as text by a reader of its own, which
// knows no more of the format than its description says.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/oracle_kinematics.hpp"

namespace inbetween {

/// A pinhole, in mm and m.
struct OracleLens {
  double focal_length_mm = 0, width_mm = 0, height_mm = 0, focus_m = 0;
};

class OracleGltf {
 public:
  /// Of a .gltf that begins with {, or of a .glb. Throws std::runtime_error where tinygltf refuses it, or
  /// warns.
  explicit OracleGltf(const std::string& bytes);
  ~OracleGltf();
  OracleGltf(const OracleGltf&) = delete;
  OracleGltf& operator=(const OracleGltf&) = delete;

  [[nodiscard]] std::vector<double> times() const;
  /// In the world of glTF: y up, metres. Between two samples on straight lines and by slerp.
  [[nodiscard]] OraclePose pose(const std::string& node, double seconds) const;
  /// The node that has the camera, its vertical angle of view (rad) and width by height.
  [[nodiscard]] std::string camera_node() const;
  [[nodiscard]] double vertical_angle() const;
  [[nodiscard]] double aspect() const;

 private:
  struct Model;
  std::unique_ptr<Model> model_;
};

class OracleUsd {
 public:
  /// Throws std::runtime_error where the text is none.
  explicit OracleUsd(const std::string& text);

  /// Of the stage: "metersPerUnit", "upAxis".
  [[nodiscard]] std::string layer(const std::string& key) const;
  /// Of the prim of that name: the attribute as it is written.
  [[nodiscard]] std::string attribute(const std::string& prim, const std::string& name) const;
  /// Of a prim by its type.
  [[nodiscard]] std::string prim_of_type(const std::string& type) const;
  [[nodiscard]] OracleLens lens() const;
  /// In the space of the stage, in its units.
  [[nodiscard]] OraclePose pose(const std::string& prim, double time_code) const;

 private:
  struct Prim {
    std::string type, name;
    int parent = -1;
    std::map<std::string, std::string> attributes = {};                         // as written
    std::map<std::string, std::map<double, std::vector<double>>> samples = {};  // by time code
  };
  [[nodiscard]] const Prim& prim(const std::string& name) const;

  std::map<std::string, std::string> layer_;
  std::vector<Prim> prims_;
};

/// The rotation and the position of a node that hangs on another.
OraclePose combined(const OraclePose& outer, const OraclePose& inner);

}  // namespace inbetween
