#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "inbetween/can/fd_frame.hpp"
#include "inbetween/can/frame.hpp"
#include "sim/drive_trouble.hpp"

namespace inbetween {

/// What a simulated drive has noted since it was asked last. Positions are in units of the drive.
struct DriveRecord {
  struct Applied {
    std::int64_t at_ns;
    double target;
  };
  struct Entered {
    std::int64_t at_ns;
    const char* state;
    double velocity;  ///< of the motor at that moment, per second
  };
  struct Reported {
    std::int64_t at_ns;
    std::uint32_t code;  ///< 0: the errors are gone
  };
  std::vector<Applied> applied;  ///< from the first time that it was in operation
  std::vector<Entered> entered;
  std::vector<Reported> reported;  ///< errors, as the protocol numbers them
};

/// A drive with its motor, whatever frames it speaks. Time is the caller's, in nanoseconds, and never goes
/// back.
class SimulatedDrive {
 public:
  virtual ~SimulatedDrive() = default;

  /// Until `now_ns`: the motor moves, timers end, reports are due.
  virtual void advance(std::int64_t now_ns) = 0;
  virtual void add_trouble(const DriveTrouble& trouble) = 0;

  /// A target was applied that is not where it was switched on.
  [[nodiscard]] virtual bool has_been_moved() const = 0;
  /// The true position of the motor in units of the drive, whatever the drive believes.
  [[nodiscard]] virtual double position() const = 0;
  [[nodiscard]] virtual double velocity() const = 0;
  /// Its state in the words of its protocol.
  [[nodiscard]] virtual const char* state_name() const = 0;
  /// It misses something that it watches, or is in fault because it did.
  [[nodiscard]] virtual bool misses_something() const = 0;
  /// Takes its own record, where it was asked to keep one.
  virtual DriveRecord take_record() = 0;
};

/// One on a bus with such frames, frame in and frame out: on a simulated bus, or on a real one.
template <class Frame>
class SimulatedDriveOn : public SimulatedDrive {
 public:
  /// A frame that it hears at the time to which it was advanced.
  virtual void receive(const Frame& frame) = 0;
  /// Takes the frames that it has to send since the last call, in order.
  std::vector<Frame> take_frames() { return std::exchange(frames_, {}); }
  /// The same, one by one, in memory that it keeps.
  template <class Take>
  void hand_frames(const Take& take) {
    for (const Frame& frame : frames_) take(frame);
    frames_.clear();
  }

 protected:
  void put_frame(const Frame& frame) { frames_.push_back(frame); }

 private:
  std::vector<Frame> frames_;
};
using SimulatedCanDrive = SimulatedDriveOn<can::Frame>;
using SimulatedFdDrive = SimulatedDriveOn<can::FdFrame>;

}  // namespace inbetween
