// The fuzzed calls about vibrations: plain ones, envelopes, PCM.
#include <limits>

#include "tests/layer/fuzz/pick.h"
#include "tests/layer/fuzz/sequence.h"

namespace omni::test {
namespace {

constexpr std::uint32_t kMostSamples = 8;

const XrHapticBaseHeader* AsHeader(const void* vibration) { return static_cast<const XrHapticBaseHeader*>(vibration); }

}  // namespace

float Sequence::AnyNumber() {
  static const float kNumbers[] = {
      0, 0.5f, 1, -1, 1e30f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()};
  return kNumbers[random_.Percent(80) ? random_.Below(3) : random_.Below(7)];
}

XrDuration Sequence::AnyDuration() {
  static constexpr XrDuration kDurations[] = {
      XR_MIN_HAPTIC_DURATION, 0, 1, 20'000'000, -77, std::numeric_limits<XrDuration>::max()};
  return random_.Percent(60) ? 20'000'000 : kDurations[random_.Below(6)];
}

// Mostly the one that Prepare has made for vibrations.
XrAction Sequence::HapticAction() {
  return vibration_ != XR_NULL_HANDLE && random_.Percent(70) ? vibration_ : Pick(actions_);
}

XrSession Sequence::MainSession() {
  return !sessions_.live.empty() && random_.Percent(60) ? sessions_.live.front() : Pick(sessions_);
}

void Sequence::CheckHaptic(const char* call, XrResult result) {
  Say(call, result);
  Expect(call, result,
         {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_PATH_INVALID, XR_ERROR_PATH_UNSUPPORTED,
          XR_ERROR_ACTION_TYPE_MISMATCH, XR_ERROR_ACTIONSET_NOT_ATTACHED, XR_SESSION_NOT_FOCUSED});
}

void Sequence::Vibrate() {
  const XrHapticActionInfo info{Type(XR_TYPE_HAPTIC_ACTION_INFO), Chain(), HapticAction(), HandPath()};
  const XrHapticVibration vibration{Type(XR_TYPE_HAPTIC_VIBRATION), Chain(), AnyDuration(), AnyNumber(), AnyNumber()};
  CheckHaptic("vibrate", f_.ApplyHapticFeedback(MainSession(), OrNull(&info), OrNull(AsHeader(&vibration))));
}

void Sequence::Stop() {
  const XrHapticActionInfo info{Type(XR_TYPE_HAPTIC_ACTION_INFO), Chain(), HapticAction(), HandPath()};
  CheckHaptic("stop", f_.StopHapticFeedback(MainSession(), OrNull(&info)));
}

void Sequence::Shape() {
  const XrHapticActionInfo info{Type(XR_TYPE_HAPTIC_ACTION_INFO), Chain(), HapticAction(), HandPath()};
  float samples[kMostSamples];
  for (float& sample : samples) sample = random_.Percent(98) ? static_cast<float>(random_.Unit()) : AnyNumber();
  const std::uint32_t count = random_.Below(kMostSamples + 1);
  if (random_.Percent(50)) {
    const XrHapticAmplitudeEnvelopeVibrationFB envelope{XR_TYPE_HAPTIC_AMPLITUDE_ENVELOPE_VIBRATION_FB, Chain(),
                                                        AnyDuration(), count, OrNull(&samples[0])};
    CheckHaptic("envelope", f_.ApplyHapticFeedback(MainSession(), OrNull(&info), AsHeader(&envelope)));
    return;
  }
  static constexpr float kRates[] = {1000, 8000, 48000, 0, -1, 1e30f};
  std::uint32_t consumed = 0;
  const XrHapticPcmVibrationFB pcm{XR_TYPE_HAPTIC_PCM_VIBRATION_FB,
                                   Chain(),
                                   count,
                                   OrNull(&samples[0]),
                                   random_.Percent(80) ? 1000 : kRates[random_.Below(6)],
                                   random_.Below(2),
                                   OrNull(&consumed)};
  CheckHaptic("pcm", f_.ApplyHapticFeedback(MainSession(), OrNull(&info), AsHeader(&pcm)));
  if (consumed > count) Violation("more samples consumed than there were");
}

void Sequence::SampleRate() {
  if (!own_.GetDeviceSampleRateFB) return;
  const XrHapticActionInfo info{Type(XR_TYPE_HAPTIC_ACTION_INFO), Chain(), HapticAction(), HandPath()};
  XrDevicePcmSampleRateStateFB rate{Type(XR_TYPE_DEVICE_PCM_SAMPLE_RATE_STATE_FB), nullptr, -1};
  const XrResult result = own_.GetDeviceSampleRateFB(MainSession(), OrNull(&info), OrNull(&rate));
  CheckHaptic("sample rate", result);
  if (XR_SUCCEEDED(result) && !(rate.sampleRate >= 0)) Violation("an invalid sample rate");
}

}  // namespace omni::test
