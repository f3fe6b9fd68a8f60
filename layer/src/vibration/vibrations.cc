// The next layer is called first wherever its device is involved: it validates, and its answer is returned. What it
// does not know (our extensions on a runtime without them) is validated here.
#include "layer/src/vibration/vibrations.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "service/base/clock.h"

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
  const bool rate_ok = pcm.sampleRate > 0 && pcm.sampleRate <= protocol::kHighestSampleRate_Hz;
  const bool valid = pcm.bufferSize > 0 && pcm.buffer && pcm.samplesConsumed && rate_ok;
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

XrHapticVibration WithoutShape(const ShapedVibration& shaped) {
  const bool envelope = shaped.waveform.kind == protocol::WaveformKind::kEnvelope;
  double sum = 0;
  for (const float sample : shaped.samples) {
    const double x = std::clamp(static_cast<double>(sample), envelope ? 0.0 : -1.0, 1.0);
    sum += envelope ? x : x * x;
  }
  const auto count = static_cast<double>(shaped.samples.size());
  double amplitude = envelope ? sum / count : std::min(1.0, std::sqrt(2 * sum / count));
  const double length_ns = envelope ? 0 : 1e9 * count / static_cast<double>(shaped.waveform.sample_rate_Hz);
  return {XR_TYPE_HAPTIC_VIBRATION, nullptr,
          envelope ? shaped.waveform.duration_ns : std::max<XrDuration>(1, static_cast<XrDuration>(length_ns)),
          XR_FREQUENCY_UNSPECIFIED, static_cast<float>(amplitude)};
}

std::uint32_t PcmBacklog::ReserveSamples(XrAction action, const ShapedVibration& pcm, std::int64_t now_ns,
                                         bool& continues) {
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

// Calls with doubtful arguments are left to the runtime, which returns the right error.
Vibrations::Channels Vibrations::Route(XrSession session, const XrHapticActionInfo* info) const {
  if (!info || info->type != XR_TYPE_HAPTIC_ACTION_INFO) return {};
  const auto record = records_.sessions.Find(session);
  const auto action = record ? records_.actions.Find(info->action) : nullptr;
  if (!action || action->type != XR_ACTION_TYPE_VIBRATION_OUTPUT) return {};
  if (!record->focused) return {};
  const std::shared_lock lock(record->mutex);
  const SessionActions& state = record->actions;
  if (!state.attached(*action->set) || !state.pen_owns_hand()) return {};
  std::vector<XrPath> below = state.SubactionsBelow(*action, info->subactionPath);
  const bool unchanged = below == std::vector<XrPath>{info->subactionPath};
  return {state.HapticBound(*action, info->subactionPath), unchanged, std::move(below)};
}

template <class Call>
XrResult Vibrations::Below(const Channels& route, const XrHapticActionInfo* info, Call call) {
  if (route.unchanged) return call(info);
  for (const XrPath path : route.below) {
    XrHapticActionInfo there = *info;
    there.subactionPath = path;
    if (const XrResult result = call(&there); result != XR_SUCCESS) return result;
  }
  return XR_SUCCESS;
}

XrResult Vibrations::ApplyHapticFeedback(XrSession session, const XrHapticActionInfo* info,
                                         const XrHapticBaseHeader* haptic) {
  if (haptic && haptic->type == XR_TYPE_HAPTIC_VIBRATION) return ApplyTone(session, info, haptic);
  if (haptic && haptic->type == XR_TYPE_HAPTIC_AMPLITUDE_ENVELOPE_VIBRATION_FB &&
      runtime_.HasExtension(XR_FB_HAPTIC_AMPLITUDE_ENVELOPE_EXTENSION_NAME))
    return ApplyEnvelope(session, info, haptic);
  if (haptic && haptic->type == XR_TYPE_HAPTIC_PCM_VIBRATION_FB &&
      runtime_.HasExtension(XR_FB_HAPTIC_PCM_EXTENSION_NAME))
    return ApplyPcm(session, info, haptic);
  return runtime_.next.ApplyHapticFeedback(session, info, haptic);
}

XrResult Vibrations::ApplyTone(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic) {
  const Channels route = Route(session, info);
  const XrResult result = Below(route, info, [&](const XrHapticActionInfo* at) {
    return runtime_.next.ApplyHapticFeedback(session, at, haptic);
  });
  if (!route.to_pen || result != XR_SUCCESS) return result;
  Play(ToPulse(ReadAs<XrHapticVibration>(haptic)));
  return result;
}

void Vibrations::Play(const Pulse& pulse) {
  backlog_.Clear();
  link_.SendHaptic(pulse.duration_ns, pulse.amplitude, pulse.frequency_Hz);
}

void Vibrations::Stop() {
  backlog_.Clear();
  link_.HapticStop();
}

// A runtime that does not know the shape gets the closest plain vibration: its devices vibrate, and it checks handles
// and paths.
XrResult Vibrations::ShapeBelow(bool only_ours, XrSession session, const XrHapticActionInfo* info,
                                const XrHapticBaseHeader* haptic, const std::optional<ShapedVibration>& shaped) const {
  if (!only_ours) return runtime_.next.ApplyHapticFeedback(session, info, haptic);
  const XrHapticVibration plain = WithoutShape(*shaped);
  return runtime_.next.ApplyHapticFeedback(session, info,
                                           static_cast<const XrHapticBaseHeader*>(static_cast<const void*>(&plain)));
}

XrResult Vibrations::ApplyEnvelope(XrSession session, const XrHapticActionInfo* info,
                                   const XrHapticBaseHeader* haptic) {
  const Channels route = Route(session, info);
  const bool only_ours = runtime_.OnlyOurs(XR_FB_HAPTIC_AMPLITUDE_ENVELOPE_EXTENSION_NAME);
  const auto shaped = ReadEnvelope(ReadAs<XrHapticAmplitudeEnvelopeVibrationFB>(haptic));
  if (!shaped && (only_ours || route.to_pen)) return XR_ERROR_VALIDATION_FAILURE;
  const XrResult result = Below(
      route, info, [&](const XrHapticActionInfo* at) { return ShapeBelow(only_ours, session, at, haptic, shaped); });
  if (!route.to_pen || result != XR_SUCCESS) return result;
  backlog_.Clear();
  link_.SendWaveform(shaped->waveform, shaped->samples);
  return result;
}

XrResult Vibrations::ApplyPcm(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic) {
  const Channels route = Route(session, info);
  const bool only_ours = runtime_.OnlyOurs(XR_FB_HAPTIC_PCM_EXTENSION_NAME);
  const auto pcm = ReadAs<XrHapticPcmVibrationFB>(haptic);
  auto shaped = ReadPcm(pcm);
  if (!shaped && (only_ours || route.to_pen)) return XR_ERROR_VALIDATION_FAILURE;
  if (pcm.samplesConsumed) *pcm.samplesConsumed = 0;
  std::uint32_t least = std::numeric_limits<std::uint32_t>::max();  // that one of the runtime's devices has taken
  const XrResult result = Below(route, info, [&](const XrHapticActionInfo* at) {
    const XrResult below = ShapeBelow(only_ours, session, at, haptic, shaped);
    if (pcm.samplesConsumed) least = std::min(least, *pcm.samplesConsumed);
    return below;
  });
  if (result != XR_SUCCESS) return result;
  if (only_ours && !route.to_pen) *pcm.samplesConsumed = static_cast<std::uint32_t>(shaped->samples.size());
  if (!route.to_pen) return result;
  // Two devices: what the other has not taken will be sent again.
  if (route.to_runtime() && !only_ours) shaped->samples.resize(std::min<std::size_t>(shaped->samples.size(), least));
  const std::uint32_t taken = PlayPcm(info->action, *shaped);
  *pcm.samplesConsumed = taken;
  return result;
}

// How many samples the service has taken.
std::uint32_t Vibrations::PlayPcm(XrAction action, ShapedVibration& pcm) {
  bool continues = false;
  pcm.samples.resize(backlog_.ReserveSamples(action, pcm, base::MonotonicNow_ns(), continues));
  pcm.waveform.append = continues ? 1 : 0;
  if (pcm.samples.empty()) return 0;
  if (link_.SendWaveform(pcm.waveform, pcm.samples)) return static_cast<std::uint32_t>(pcm.samples.size());
  backlog_.Clear();  // nothing plays: the application tries again
  return 0;
}

XrResult Vibrations::StopHapticFeedback(XrSession session, const XrHapticActionInfo* info) {
  const Channels route = Route(session, info);
  const XrResult result =
      Below(route, info, [&](const XrHapticActionInfo* at) { return runtime_.next.StopHapticFeedback(session, at); });
  if (route.to_pen && result == XR_SUCCESS) Stop();
  return result;
}

// [xrGetDeviceSampleRateFB] The pen's coils for the pen's hand; without the extension below, 0 for all else.
XrResult Vibrations::GetDeviceSampleRateFB(XrSession session, const XrHapticActionInfo* info,
                                           XrDevicePcmSampleRateStateFB* rate) {
  link_.SignalAlive();
  const auto record = records_.sessions.Find(session);
  const bool readable =
      info && info->type == XR_TYPE_HAPTIC_ACTION_INFO && rate && rate->type == XR_TYPE_DEVICE_PCM_SAMPLE_RATE_STATE_FB;
  const auto action = record && readable ? records_.actions.Find(info->action) : nullptr;
  if (action && action->type == XR_ACTION_TYPE_VIBRATION_OUTPUT) {
    const std::shared_lock lock(record->mutex);
    const bool declared = info->subactionPath == XR_NULL_PATH || action->HasSubaction(info->subactionPath);
    const bool bound = record->actions.HapticBound(*action, info->subactionPath);
    if (declared && bound) {
      rate->sampleRate = protocol::kDeviceSampleRate_Hz;
      return XR_SUCCESS;
    }
  }
  if (runtime_.next.GetDeviceSampleRateFB) return runtime_.next.GetDeviceSampleRateFB(session, info, rate);
  if (!record) return XR_ERROR_HANDLE_INVALID;
  if (!readable) return XR_ERROR_VALIDATION_FAILURE;
  if (!action) return XR_ERROR_HANDLE_INVALID;
  if (action->type != XR_ACTION_TYPE_VIBRATION_OUTPUT) return XR_ERROR_ACTION_TYPE_MISMATCH;
  if (info->subactionPath != XR_NULL_PATH && !action->HasSubaction(info->subactionPath)) {
    return runtime_.PathText(info->subactionPath).empty() ? XR_ERROR_PATH_INVALID : XR_ERROR_PATH_UNSUPPORTED;
  }
  const std::shared_lock lock(record->mutex);
  if (!record->actions.attached(*action->set)) return XR_ERROR_ACTIONSET_NOT_ATTACHED;
  rate->sampleRate = 0;
  return XR_SUCCESS;
}

}  // namespace omni::layer
