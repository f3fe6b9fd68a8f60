// Collects all objections of a rule into the single finding of a diagnosis.
#pragma once

#include <string>

#include "service/tools/doctor/diagnosis.h"

namespace omni::tools {

class Objections {
 public:
  void Add(Verdict verdict, const std::string& what, const std::string& fix) {
    if (verdict > sum_.verdict) sum_.verdict = verdict;
    sum_.what += (sum_.what.empty() ? "" : "; ") + what;
    if (sum_.fix.find(fix) == std::string::npos) sum_.fix += (sum_.fix.empty() ? "" : "; ") + fix;
  }
  // All of them with the worst verdict; `ok` when there is none.
  Finding Sum(const std::string& ok) const { return sum_.what.empty() ? Finding{Verdict::kOk, ok, {}} : sum_; }

 private:
  Finding sum_;
};

}  // namespace omni::tools
