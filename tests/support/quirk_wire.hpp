#pragma once

#include <memory>
#include <span>
#include <vector>

#include "inbetween/can/frame.hpp"

namespace inbetween {

/// What is between the host and the drive of a QuirkScene.
class QuirkWire {
 public:
  enum class Sender { host, drive };
  virtual ~QuirkWire() = default;
  /// The other side hears these, in order and at once.
  virtual std::vector<can::Frame> carry(std::span<const can::Frame> frames, Sender from) = 0;
};

/// In the bench the kernel's interface can0, with a socket at either end that lets in what the program and
/// node 5 hear; elsewhere memory.
std::unique_ptr<QuirkWire> make_quirk_wire();

}  // namespace inbetween
