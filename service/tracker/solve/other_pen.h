// Pose and moment of a pen that may be another one than before. docs/theory/tracking.md, Other pens
#pragma once

#include "service/tracker/stages/scan_context.h"

namespace omni::tracker {

// Pose and moment without a hint, in the ambient field of `drift`, of which `measurement` is. If it is good, `drift`
// holds the moment, and `measurement` is of it.
Outcome SeekOtherPen(const ScanContext& context, const Doubt& doubt, DriftState& drift, Measurement& measurement,
                     Magnet& magnet) noexcept;

// A scan that fits the magnet that was there last, which may have been exchanged. If it needs another ambient field,
// would another pen do, in the field as it was (`before`)? Does it contradict that moment? Then both are searched, in
// that field, else in any. If it says too little, the moment is an unknown of the scans to come.
void MeetMagnet(const ScanContext& context, const DriftState& before, const Doubt& doubt, DriftState& drift,
                Measurement& measurement, Outcome& outcome, Magnet& magnet) noexcept;

// At a meeting: would one magnet do, whatever its moment, where a pen and a magnet have been found?
bool IsOneMagnet(const ScanContext& context, const RoomState& room, const Fit& found) noexcept;

}  // namespace omni::tracker
