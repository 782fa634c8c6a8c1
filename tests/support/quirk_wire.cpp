#include "tests/support/quirk_wire.hpp"

#include <cstdlib>
#include <stdexcept>

#include "drivers/can/socket_can.hpp"

namespace inbetween {
namespace {

class MemoryWire final : public QuirkWire {
 public:
  std::vector<can::Frame> carry(std::span<const can::Frame> frames, Sender /*from*/) override {
    return {frames.begin(), frames.end()};
  }
};

class KernelWire final : public QuirkWire {
 public:
  KernelWire() {
    open(host_, {{0x000}, {0x080}, {0x77F}, {0x185}, {0x205}, {0x705}, {0x085}, {0x585}, {0x605}});
    open(drive_, {{0x000}, {0x080}, {0x77F}, {0x205}, {0x605}, {.id = 0x705, .is_remote = true}});
  }
  /// The kernel hands a frame of a virtual interface over while it is sent. A frame that is not there soon
  /// after is lost.
  std::vector<can::Frame> carry(std::span<const can::Frame> frames, Sender from) override {
    can::SocketCan& sender = from == Sender::host ? host_ : drive_;
    can::SocketCan& receiver = from == Sender::host ? drive_ : host_;
    if (sender.send(frames) != frames.size()) throw std::runtime_error("can0 has not taken a frame");
    std::vector<can::Frame> heard(frames.size());
    std::size_t count = 0;
    for (int looks = 0; count < frames.size(); ++looks) {
      constexpr int max_looks = 100'000;
      if (looks == max_looks) throw std::runtime_error("a frame was lost on can0");
      count += receiver.receive(std::span(heard).subspan(count));
    }
    return heard;
  }

 private:
  static void open(can::SocketCan& socket, const std::vector<can::CanFilter>& filters) {
    if (const auto refusal = socket.open("can0", filters)) throw std::runtime_error(refusal->what);
  }
  can::SocketCan host_;
  can::SocketCan drive_;
};

}  // namespace

std::unique_ptr<QuirkWire> make_quirk_wire() {
  if (std::getenv("INBETWEEN_IN_BENCH") == nullptr) return std::make_unique<MemoryWire>();
  return std::make_unique<KernelWire>();
}

}  // namespace inbetween
