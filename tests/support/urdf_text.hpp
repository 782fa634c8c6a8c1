// Random URDF arms as text, with what people's files have besides: shapes, masses, mimic joints, turned fixed
// links.
#pragma once

#include <cstddef>
#include <random>
#include <string>
#include <vector>

namespace inbetween {

struct UrdfTextJoint {
  std::string name;
  std::string type;
  double lower = 0, upper = 0;  // rad or m
  bool mimics = false;
};

struct UrdfText {
  std::string text;
  std::vector<UrdfTextJoint> joints;  // those that move
  std::string tip;
};

/// An arm of `moving` joints that are driven, and other joints between and beside them.
UrdfText random_urdf(std::mt19937_64& random, std::size_t moving);

}  // namespace inbetween
