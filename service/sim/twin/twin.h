// The digital twin: a simulated base, pen and hand behind device::Transport. It is a simulation, and says so in
// TransportInfo. It judges the tracker and actuation, so it shares no field code with them.
// The pen's true pose leaves it only into a recording that is read after the run.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/base/result.h"
#include "service/base/truth_parameters.h"
#include "service/device/transport.h"
#include "service/sim/fields/tremor.h"
#include "service/sim/hand/hand_guide.h"

namespace omni::sim {

// The hand's path: the spring-damper's other end follows it, the pen yields to rendered forces.
struct HandWaypoint {
  double duration_s = 0;  // time to get here from the last waypoint, smooth (minimum jerk), >= 0
  base::Vec3 tip_base_m;  // wanted device point
  base::Vec3 axis_base{0, 0, -1};
  bool present = true;  // false: the pen is taken away (out of reach) during this leg
};
struct HandScript {
  std::string name;
  std::vector<HandWaypoint> waypoints;  // at least one; the first is the start
  bool repeat = false;                  // after the last waypoint back to the first, within the first one's duration
  double stiffness_N_m = 150, damping_Ns_m = 3, mass_kg = 0.12, tremor_m = 0.0;  // tremor: rms
  TremorBand tremor_band;
  double duration_s() const;  // of one pass from the first to the last waypoint
};
// JSON: {"name", "repeat", "hand": {"stiffness_N_m", ...}, "waypoints": [{"s", "tip_m":[3], "axis":[3], "present"}]}
base::Result<HandScript> LoadHandScript(const std::string& path);

struct TwinOptions {
  std::uint64_t seed = 1;
  HandScript script;  // as LoadHandScript accepts it; no waypoints: no pen
  // null: the script is played; else it guides the hand, and the script's path is not played
  std::shared_ptr<HandGuide> guide;
  bool imperfect = true;        // false: nominal device, nothing but noise and heat (tests of other parts)
  base::TruthParameters truth;  // how far from nominal, what happens over time; config::DefaultTwin() has it all
  bool flip_coil_sign = false;  // test hook: coil z wired backwards
  std::string recording_path;   // CSV of truth and currents, every device tick; empty: none
  bool real_time = true;        // ServeTwin asks for SCHED_FIFO; refused is fine
};

// Twin in this process, in virtual time: every Read() advances 1 ms and returns at once, kEnd after duration_s.
// Equal seed, script and commands give equal bits.
std::unique_ptr<device::Transport> MakeVirtualTwin(const base::DeviceGeometry& device, const TwinOptions& options,
                                                   double duration_s);

// Twin in a process of its own (omni-twin): real time, 1 kHz, frames of firmware/wire over the seqpacket socket
// `fd`. Returns when the peer has been gone for `linger_s` (the recording goes on until then). Exit code for main.
int ServeTwin(const base::DeviceGeometry& device, const TwinOptions& options, int fd, double linger_s);

// Starts `program` ("…/omni-twin") with `--fd N args...` and talks to it.
base::Result<std::unique_ptr<device::Transport>> SpawnTwin(const std::string& program,
                                                           const std::vector<std::string>& args);

}  // namespace omni::sim
