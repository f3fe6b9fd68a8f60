#include "service/room/room_watch.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "service/base/clock.h"

namespace omni::room {
namespace {

RoomFinding Swapped(const std::pair<int, int>& pair) {
  return {.kind = "sensors-swapped",
          .sensors = {pair.first, pair.second},
          .what = "sensors " + std::to_string(pair.first) + " and " + std::to_string(pair.second) +
                  " are swapped (cables or addresses): a pose explains their readings only when they are exchanged",
          .fix = "exchange their cables or addresses"};
}

RoomFinding Softened() {
  return {.kind = "contact-softened",
          .sensors = {},
          .what = "what the pen touches made it swing, or gave it energy, and is softer for now",
          .fix = "hold the pen more firmly; if it comes back, other programs may be delaying omnid: omni doctor"};
}

constexpr int kSoftened_s = 10;

}  // namespace

void PenWatch::Add(const base::ToolState& tool) noexcept {
  if (tool.status != base::TrackingStatus::kTracking || tool.magnet == base::MagnetIdentity::kUnknown) return;
  ++tracked_;
  if (tool.magnet == base::MagnetIdentity::kCalibrated) return;
  ++other_;
  sum_ += tool.moment_scale;
  sigma_sum_ += tool.moment_sigma;
}

void PenWatch::EndSecond() noexcept {
  if (tracked_ > 0) {
    const double scale = other_ > 0 ? sum_ / other_ : 1;
    is_other_.Add(IsMostly(other_, tracked_) && std::abs(scale - 1) >= kOther);
    if (other_ > 0 && std::abs(scale - moment_scale_) >= kChanged) {
      moment_scale_ = scale;
      moment_sigma_ = sigma_sum_ / other_;
    }
  }
  tracked_ = other_ = 0;
  sum_ = sigma_sum_ = 0;
}

void PenWatch::Report(std::vector<RoomFinding>& findings) const {
  if (!is_other_.holds()) return;
  const long percent = std::lround(100 * std::abs(moment_scale_ - 1));
  const long sigma = std::max(1L, static_cast<long>(std::ceil(100 * moment_sigma_)));
  findings.push_back({.kind = "other-pen",
                      .sensors = {},
                      .what = "this magnet is " + std::to_string(percent) + " +- " + std::to_string(sigma) + " % " +
                              (moment_scale_ > 1 ? "stronger" : "weaker") +
                              " than the one calibrated: another pen; poses and forces are those of this one",
                      .fix = "nothing needs to be done; if you keep it: omni calibrate --replace"});
}

RoomWatch::RoomWatch(const base::Calibration* calibration) {
  if (calibration == nullptr || calibration->sensors.size() != base::kSensorCount) return;
  field_.emplace(*calibration);
  swap_.emplace(*calibration);
}

bool RoomWatch::Add(const tracker::RoomSample& sample) {
  if (sample.scan.t_ns == last_ns_) return false;
  last_ns_ = sample.scan.t_ns;
  const bool near = sample.tool.field_rms_T >= tracker::kMagnetNear_T;
  const bool contradicted = near && (sample.tool.limits & base::kToolContradicted) != 0;
  ++samples_;
  near_ += near ? 1 : 0;
  contradicted_ += contradicted ? 1 : 0;
  softened_ = softened_ || sample.contact_gain < 1;
  sensors_.Add(sample);
  if (field_) field_->Add(sample);
  pen_.Add(sample.tool);
  if (swap_ && contradicted && is_contradicted_.holds()) swap_->Keep(sample.scan);
  if (swap_) swap_->Step();
  const std::int64_t elapsed_ns = base::StampDifference_ns(last_ns_, second_ns_);
  if (elapsed_ns >= 0 && elapsed_ns < kSecond_ns) return false;
  EndSecond();
  std::vector<RoomFinding> now = Report();
  if (now == findings_) return false;
  findings_ = std::move(now);
  return true;
}

void RoomWatch::EndSecond() {
  second_ns_ = last_ns_;
  softened_s_ = softened_ ? kSoftened_s : std::max(0, softened_s_ - 1);
  softened_ = false;
  if (near_ >= kSamplesMin) {
    is_contradicted_.Add(2 * contradicted_ > near_);
    if (swap_ && !is_contradicted_.holds()) swap_->Forget();
  }
  const bool enough = samples_ >= kSamplesMin;
  const bool contradicted = IsMostly(contradicted_, samples_);
  samples_ = near_ = contradicted_ = 0;
  if (!enough) return;
  sensors_.EndSecond();
  pen_.EndSecond();
  if (!field_) return;
  field_->EndSecond(sensors_.useless(), contradicted && !IsExplained());
  if (field_->field_T() && !IsExplained()) room_field_ = RoomField{base::FromEigen(*field_->field_T()), second_ns_};
}

std::vector<RoomFinding> RoomWatch::Report() const {
  std::vector<RoomFinding> findings;
  sensors_.Report(field_ && field_->magnet_near(), findings);
  if (swap_ && swap_->found()) findings.push_back(Swapped(*swap_->found()));
  if (field_ && !IsExplained()) field_->Report(findings);
  if (softened_s_ > 0) findings.push_back(Softened());
  pen_.Report(findings);
  return findings;
}

bool RoomWatch::IsExplained() const noexcept { return sensors_.too_few() || (swap_ && swap_->found().has_value()); }

bool RoomWatch::explains_misfit() const noexcept { return IsExplained() || (field_ && field_->magnet_near()); }

}  // namespace omni::room
