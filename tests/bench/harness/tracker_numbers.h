// Every number in the tracker's options, by name: what `omni-bench numbers` puts on trial.
#pragma once

#include <span>
#include <string>
#include <variant>
#include <vector>

#include "service/tracker/tracker.h"

namespace omni::bench {

struct TrackerNumber {
  std::string name;                                   // of the member, after that of its struct in Config
  std::variant<double*, int*, std::span<double>> at;  // in the configuration; several are scaled together
};

std::vector<TrackerNumber> TrackerNumbers(tracker::Config& config);

double ValueOf(const TrackerNumber& number);  // of several: the largest
// A whole number changes by one at least, away from zero if the factor is above 1.
void Scale(double factor, const TrackerNumber& number);

}  // namespace omni::bench
