#include "service/tracker/stages/predict.h"

#include <algorithm>

#include "service/base/clock.h"
#include "service/tracker/stages/scan_context.h"

namespace omni::tracker {
namespace {

void Start(const Config& config, const base::HallScan& scan, RoomState& room) noexcept {
  room.doubt.model_error = config.doubt.model_error_start;
  StartAway(config.away, scan.t_ns, room.away);
  StartMagnet(config.magnets, LearnsDrift(config), room.magnet);
  if (LearnsDrift(config)) PredictDrift(config.drift, scan.t_ns, nullptr, room.drift);
}

// Leaves out a sensor that repeats the same reading before it becomes wrong.
void BlameFrozen(const Config& config, const base::HallScan& scan, RoomState& room) noexcept {
  const int frozen = FindFrozen(scan, config.doubt.frozen_scans, room.repetition);
  if (frozen >= 0 && room.doubt.left_out < 0 && CanDoubt(config, room)) ExcludeSensor(config.doubt, frozen, room.doubt);
}

}  // namespace

bool IsRepeated(const Config& config, const base::HallScan& as_read, RoomState& room) noexcept {
  const bool old = room.currents.valid && as_read.t_ns == room.currents.t_ns;
  room.old_scans = old ? std::min(room.old_scans + 1, config.lost_after_scans) : 0;
  return old;
}

Received Receive(const Config& config, const base::HallScan& as_read, RoomState& room) noexcept {
  if (room.scans++ == 0) Start(config, as_read, room);
  BlameFrozen(config, as_read, room);
  Received received{.as_read = as_read, .zeroed = {}};
  received.frozen = IsAllFrozen(as_read, config.doubt.frozen_scans, room.repetition);
  received.since_last_s = base::Elapsed_s(as_read.t_ns, room.currents.t_ns);
  if (room.away.learnt) SubtractZeros(room.away, received.zeroed.emplace(as_read));
  room.currents_before = room.currents;
  room.currents = UpdatedHistory(as_read, room.currents_before);
  return received;
}

}  // namespace omni::tracker
