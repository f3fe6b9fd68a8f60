// The next layer is asked first wherever its device has a part: it validates, and its answer stands. What it does not
// know (our extensions on a runtime without them) is validated here.
#include "layer/src/haptics.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "layer/src/fault.h"
#include "layer/src/instance.h"

namespace omni::layer {
namespace {

bool AllFinite(const float* values, std::size_t count) {
  return std::all_of(values, values + count, [](float value) { return std::isfinite(value); });
}

// `count` values as at most `most`: each the mean of its share.
std::vector<float> Shrunk(const float* values, std::size_t count, std::size_t most) {
  const std::size_t size = std::min(count, most);
  std::vector<float> out(size);
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t from = i * count / size, to = (i + 1) * count / size;
    double sum = 0;
    for (std::size_t k = from; k < to; ++k) sum += static_cast<double>(values[k]);
    out[i] = static_cast<float>(sum / static_cast<double>(to - from));
  }
  return out;
}

template <class T>
T ReadAs(const XrHapticBaseHeader* haptic) {
  T out;
  std::memcpy(&out, haptic, sizeof(out));
  return out;
}

}  // namespace

std::optional<ShapedVibration> ReadEnvelope(const XrHapticAmplitudeEnvelopeVibrationFB& envelope) {
  const bool valid = envelope.amplitudeCount > 0 && envelope.amplitudes &&
                     envelope.duration >= XR_MIN_HAPTIC_DURATION &&
                     AllFinite(envelope.amplitudes, envelope.amplitudeCount);
  if (!valid) return std::nullopt;
  ShapedVibration out;
  out.waveform.kind = protocol::WaveformKind::kEnvelope;
  out.waveform.duration_ns = envelope.duration;
  out.samples = Shrunk(envelope.amplitudes, envelope.amplitudeCount, protocol::kMaxWaveformSamples);
  return out;
}

std::optional<ShapedVibration> ReadPcm(const XrHapticPcmVibrationFB& pcm) {
  const bool valid = pcm.bufferSize > 0 && pcm.buffer && pcm.samplesConsumed && pcm.sampleRate > 0 &&
                     pcm.sampleRate <= protocol::kHighestSampleRate_Hz;
  if (!valid) return std::nullopt;
  const std::size_t count = std::min(pcm.bufferSize, protocol::kMaxWaveformSamples);
  if (!AllFinite(pcm.buffer, count)) return std::nullopt;
  ShapedVibration out;
  out.waveform.kind = protocol::WaveformKind::kPcm;
  out.waveform.sample_rate_Hz = pcm.sampleRate;
  out.waveform.append = pcm.append == XR_TRUE ? 1 : 0;
  out.samples.assign(pcm.buffer, pcm.buffer + count);
  return out;
}

std::uint32_t PcmBacklog::Book(XrAction action, const ShapedVibration& pcm, std::int64_t now_ns, bool& continues) {
  const std::lock_guard lock(mutex_);
  continues = pcm.waveform.append == 1 && action == action_ && end_ns_ > now_ns;
  const std::int64_t begin_ns = continues ? end_ns_ : now_ns;
  const double rate_Hz = static_cast<double>(pcm.waveform.sample_rate_Hz);
  const double room_s = protocol::kWaveformBuffer_s - 1e-9 * static_cast<double>(begin_ns - now_ns);
  const double room = std::max(0.0, std::floor(room_s * rate_Hz));
  const auto taken = static_cast<std::uint32_t>(std::min(room, static_cast<double>(pcm.samples.size())));
  action_ = action;
  end_ns_ = begin_ns + static_cast<std::int64_t>(1e9 * taken / rate_Hz);
  return taken;
}

void PcmBacklog::Clear() {
  const std::lock_guard lock(mutex_);
  action_ = XR_NULL_HANDLE;
  end_ns_ = 0;
}

// Any doubt about the arguments leaves the call to the runtime, which knows the right error.
Instance::HapticRoute Instance::RouteHaptic(XrSession session, const XrHapticActionInfo* info) const {
  if (!info || info->type != XR_TYPE_HAPTIC_ACTION_INFO) return {};
  const auto record = sessions.Find(session);
  const auto action = record ? actions.Find(info->action) : nullptr;
  if (!action || action->type != XR_ACTION_TYPE_VIBRATION_OUTPUT) return {};
  if (!record->focused && !OMNI_FAULT("haptic-without-focus")) return {};
  const std::shared_lock lock(record->mutex);
  const SessionActions& state = record->actions;
  if (!state.attached(*action->set) || !state.pen_owns_hand()) return {};
  const bool our_hand = info->subactionPath == state.hand_path() && action->Declares(state.hand_path());
  return {state.HapticBound(*action, info->subactionPath), !our_hand && !OMNI_FAULT("haptic-to-pen-only")};
}

XrResult Instance::ApplyHaptic(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic) {
  Alive();
  if (haptic && haptic->type == XR_TYPE_HAPTIC_VIBRATION) return ApplyTone(session, info, haptic);
  if (haptic && haptic->type == XR_TYPE_HAPTIC_AMPLITUDE_ENVELOPE_VIBRATION_FB &&
      Enabled(XR_FB_HAPTIC_AMPLITUDE_ENVELOPE_EXTENSION_NAME))
    return ApplyEnvelope(session, info, haptic);
  if (haptic && haptic->type == XR_TYPE_HAPTIC_PCM_VIBRATION_FB && Enabled(XR_FB_HAPTIC_PCM_EXTENSION_NAME))
    return ApplyPcm(session, info, haptic);
  return next.ApplyHapticFeedback(session, info, haptic);
}

XrResult Instance::ApplyTone(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic) {
  const HapticRoute route = RouteHaptic(session, info);
  const XrResult result = route.to_runtime ? next.ApplyHapticFeedback(session, info, haptic) : XR_SUCCESS;
  if (!route.to_pen || result != XR_SUCCESS) return result;
  const auto v = ReadAs<XrHapticVibration>(haptic);
  // XR_MIN_HAPTIC_DURATION is -1, as in the protocol. NaN fails the comparison and becomes rest.
  const float amplitude = v.amplitude >= 0 ? std::min(v.amplitude, 1.0f) : 0.0f;
  const float frequency_Hz = v.frequency >= 0 ? v.frequency : 0.0f;
  pcm_backlog.Clear();
  link.Haptic(std::max<XrDuration>(v.duration, XR_MIN_HAPTIC_DURATION), amplitude, frequency_Hz);
  return result;
}

// Of a vibration that a runtime without the extension cannot play: it is asked where the pen has no part, and its
// answer stands; with the pen among several devices, only the pen vibrates.
XrResult Instance::AskBelow(const HapticRoute& route, const char* extension, XrSession session,
                            const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic) {
  const bool can = !OnlyOurs(extension) || !route.to_pen;
  return route.to_runtime && can ? next.ApplyHapticFeedback(session, info, haptic) : XR_SUCCESS;
}

XrResult Instance::ApplyEnvelope(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic) {
  const HapticRoute route = RouteHaptic(session, info);
  const auto shaped = ReadEnvelope(ReadAs<XrHapticAmplitudeEnvelopeVibrationFB>(haptic));
  if (route.to_pen && !shaped) return XR_ERROR_VALIDATION_FAILURE;
  const XrResult result = AskBelow(route, XR_FB_HAPTIC_AMPLITUDE_ENVELOPE_EXTENSION_NAME, session, info, haptic);
  if (!route.to_pen || result != XR_SUCCESS) return result;
  pcm_backlog.Clear();
  link.Waveform(shaped->waveform, shaped->samples);
  return result;
}

XrResult Instance::ApplyPcm(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic) {
  const HapticRoute route = RouteHaptic(session, info);
  const auto pcm = ReadAs<XrHapticPcmVibrationFB>(haptic);
  auto shaped = ReadPcm(pcm);
  if (route.to_pen && !shaped) return XR_ERROR_VALIDATION_FAILURE;
  if (pcm.samplesConsumed) *pcm.samplesConsumed = 0;
  const XrResult result = AskBelow(route, XR_FB_HAPTIC_PCM_EXTENSION_NAME, session, info, haptic);
  if (!route.to_pen || result != XR_SUCCESS) return result;
  // Two devices: what the other has not taken will be sent again.
  const bool both = route.to_runtime && !OnlyOurs(XR_FB_HAPTIC_PCM_EXTENSION_NAME);
  if (both) shaped->samples.resize(std::min<std::size_t>(shaped->samples.size(), *pcm.samplesConsumed));
  *pcm.samplesConsumed = 0;
  bool continues = false;
  shaped->samples.resize(pcm_backlog.Book(info->action, *shaped, MonotonicNow_ns(), continues));
  shaped->waveform.append = continues ? 1 : 0;
  if (shaped->samples.empty()) return result;
  if (link.Waveform(shaped->waveform, shaped->samples)) {
    *pcm.samplesConsumed = static_cast<std::uint32_t>(shaped->samples.size());
  } else {
    pcm_backlog.Clear();  // nothing plays: the application tries again
  }
  return result;
}

XrResult Instance::StopHaptic(XrSession session, const XrHapticActionInfo* info) {
  Alive();
  const HapticRoute route = RouteHaptic(session, info);
  const XrResult result = route.to_runtime ? next.StopHapticFeedback(session, info) : XR_SUCCESS;
  if (route.to_pen && result == XR_SUCCESS) {
    pcm_backlog.Clear();
    if (!OMNI_FAULT("haptic-stop-dropped")) link.HapticStop();
  }
  return result;
}

// [xrGetDeviceSampleRateFB] The pen's coils for the pen's hand; without the extension below, 0 for all else.
XrResult Instance::DeviceSampleRate(XrSession session, const XrHapticActionInfo* info,
                                    XrDevicePcmSampleRateStateFB* rate) {
  link.Beat();
  const auto record = sessions.Find(session);
  const bool readable =
      info && info->type == XR_TYPE_HAPTIC_ACTION_INFO && rate && rate->type == XR_TYPE_DEVICE_PCM_SAMPLE_RATE_STATE_FB;
  const auto action = record && readable ? actions.Find(info->action) : nullptr;
  if (action && action->type == XR_ACTION_TYPE_VIBRATION_OUTPUT) {
    const std::shared_lock lock(record->mutex);
    const bool declared = info->subactionPath == XR_NULL_PATH || action->Declares(info->subactionPath);
    if (declared && record->actions.HapticBound(*action, info->subactionPath)) {
      rate->sampleRate = protocol::kDeviceSampleRate_Hz;
      return XR_SUCCESS;
    }
  }
  if (next.GetDeviceSampleRateFB) return next.GetDeviceSampleRateFB(session, info, rate);
  if (!record) return XR_ERROR_HANDLE_INVALID;
  if (!readable) return XR_ERROR_VALIDATION_FAILURE;
  if (!action) return XR_ERROR_HANDLE_INVALID;
  if (action->type != XR_ACTION_TYPE_VIBRATION_OUTPUT) return XR_ERROR_ACTION_TYPE_MISMATCH;
  if (info->subactionPath != XR_NULL_PATH && !action->Declares(info->subactionPath)) {
    return PathText(info->subactionPath).empty() ? XR_ERROR_PATH_INVALID : XR_ERROR_PATH_UNSUPPORTED;
  }
  const std::shared_lock lock(record->mutex);
  if (!record->actions.attached(*action->set)) return XR_ERROR_ACTIONSET_NOT_ATTACHED;
  rate->sampleRate = 0;
  return XR_SUCCESS;
}

}  // namespace omni::layer
