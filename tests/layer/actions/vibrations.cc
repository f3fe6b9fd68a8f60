// Vibrations with shape: XR_FB_haptic_amplitude_envelope and XR_FB_haptic_pcm over a runtime that has neither, and one
// that has both.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "layer/src/vibration/vibrations.h"
#include "tests/layer/support/app.h"

namespace omni::test {
namespace test_vibrations {

using protocol::WaveformKind;

AppOptions WithShapes() {
  AppOptions options;
  options.extensions = {XR_FB_HAPTIC_AMPLITUDE_ENVELOPE_EXTENSION_NAME, XR_FB_HAPTIC_PCM_EXTENSION_NAME};
  return options;
}

std::vector<float> Noise(std::size_t count, float least, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(least, 1.0f);
  std::vector<float> values(count);
  for (float& value : values) value = uniform(random);
  return values;
}

class Vibrations : public testing::Test {
 protected:
  void SetUp() override { omni_test_reset(); }

  template <class T>
  static XrResult Apply(const App& app, XrPath hand, const T& vibration) {
    const XrHapticActionInfo info{XR_TYPE_HAPTIC_ACTION_INFO, nullptr, app.haptic, hand};
    return xrApplyHapticFeedback(app.session, &info,
                                 static_cast<const XrHapticBaseHeader*>(static_cast<const void*>(&vibration)));
  }
  static XrHapticAmplitudeEnvelopeVibrationFB Envelope(const std::vector<float>& values, XrDuration duration) {
    return {XR_TYPE_HAPTIC_AMPLITUDE_ENVELOPE_VIBRATION_FB, nullptr, duration,
            static_cast<std::uint32_t>(values.size()), values.data()};
  }
  XrHapticPcmVibrationFB Pcm(const std::vector<float>& values, float rate_Hz, bool append) {
    consumed_ = 12345;
    return {
        XR_TYPE_HAPTIC_PCM_VIBRATION_FB, nullptr,   static_cast<std::uint32_t>(values.size()), values.data(), rate_Hz,
        static_cast<XrBool32>(append),   &consumed_};
  }
  static bool HasWaveforms(const FakeService& service, std::size_t count) {
    for (int i = 0; i < 2000; ++i) {
      if (service.heard().waveforms.size() >= count) return true;
      const timespec pause{0, 2'000'000};
      nanosleep(&pause, nullptr);
    }
    return false;
  }
  static float Rate(const App& app, XrPath hand) {
    PFN_xrVoidFunction function = nullptr;
    EXPECT_EQ(xrGetInstanceProcAddr(app.instance, "xrGetDeviceSampleRateFB", &function), XR_SUCCESS);
    if (function == nullptr) return -1;
    const XrHapticActionInfo info{XR_TYPE_HAPTIC_ACTION_INFO, nullptr, app.haptic, hand};
    XrDevicePcmSampleRateStateFB rate{XR_TYPE_DEVICE_PCM_SAMPLE_RATE_STATE_FB, nullptr, -1};
    EXPECT_EQ(reinterpret_cast<PFN_xrGetDeviceSampleRateFB>(function)(app.session, &info, &rate), XR_SUCCESS);
    return rate.sampleRate;
  }
  static OmniTestHaptics Device(const char* hand) {
    OmniTestHaptics haptics{};
    EXPECT_EQ(omni_test_haptics(hand, &haptics), 0);
    return haptics;
  }
  std::uint32_t consumed_ = 0;
};

// [XR_FB_haptic_amplitude_envelope] The service receives each amplitude unchanged.
// All bound devices vibrate, and in the pen's hand this is the pen: not the controller that lies on the desk.
TEST_F(Vibrations, NullPathSparesTheControllerOfThePensHand) {
  omni_test_set_device("right", 1, kTouch);
  omni_test_offer_shapes(1);
  FakeService service;
  App app(WithShapes());
  ASSERT_TRUE(app.SyncUntil(service, [&] { return app.Float(app.force, app.right).isActive == XR_TRUE; }));
  service.Set(protocol::InputIndex::kTipForce, 0.25f);
  ASSERT_TRUE(app.SyncUntil(service, [&] { return app.Float(app.force, app.right).currentState == 0.25f; }));
  ASSERT_EQ(app.Vibrate(XR_NULL_PATH, 0.5f), XR_SUCCESS);
  const std::vector<float> noise = Noise(200, -1, 1);
  ASSERT_EQ(Apply(app, XR_NULL_PATH, Pcm(noise, 1000, false)), XR_SUCCESS);
  EXPECT_EQ(consumed_, 200u);
  ASSERT_EQ(Apply(app, XR_NULL_PATH, Envelope(noise, 20'000'000)), XR_SUCCESS);
  const XrHapticActionInfo all{XR_TYPE_HAPTIC_ACTION_INFO, nullptr, app.haptic, XR_NULL_PATH};
  ASSERT_EQ(xrStopHapticFeedback(app.session, &all), XR_SUCCESS);
  OmniTestHaptics left{}, right{};
  omni_test_haptics("left", &left);
  omni_test_haptics("right", &right);
  EXPECT_EQ(left.count, 1u);
  EXPECT_EQ(left.pcms, 1u);
  EXPECT_EQ(left.envelopes, 1u);
  EXPECT_EQ(left.stops, 1u);
  EXPECT_EQ(right.count + right.pcms + right.envelopes + right.stops, 0u);
  EXPECT_TRUE(Eventually([&] { return service.heard().haptics.size() == 1; }));
  EXPECT_TRUE(HasWaveforms(service, 2));
  // The pen gone, it is the controller's hand again.
  service.SetFlags(0);
  ASSERT_TRUE(app.SyncUntil(service, [&] { return app.Float(app.force, app.right).currentState != 0.25f; }));
  ASSERT_EQ(app.Vibrate(XR_NULL_PATH, 0.5f), XR_SUCCESS);
  omni_test_haptics("right", &right);
  EXPECT_EQ(right.count, 1u);
}

TEST_F(Vibrations, EnvelopeReachesServiceUnchanged) {
  FakeService service;
  App app(WithShapes());
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  const std::vector<float> values = Noise(4000, 0, 1);
  ASSERT_EQ(Apply(app, app.right, Envelope(values, 1'500'000'000)), XR_SUCCESS);
  ASSERT_TRUE(HasWaveforms(service, 1)) << "at once, not at the sync";
  const Heard::Shaped heard = service.heard().waveforms[0];
  EXPECT_EQ(heard.waveform.kind, WaveformKind::kEnvelope);
  EXPECT_EQ(heard.waveform.duration_ns, 1'500'000'000);
  EXPECT_EQ(heard.samples, values);
  ASSERT_EQ(Apply(app, app.right, Envelope({0.5f}, XR_MIN_HAPTIC_DURATION)), XR_SUCCESS);
  ASSERT_TRUE(HasWaveforms(service, 2));
  EXPECT_EQ(service.heard().waveforms[1].waveform.duration_ns, -1);
}

// [XR_FB_haptic_pcm] samplesConsumed is written before return; append continues, a full buffer takes no more.
TEST_F(Vibrations, PcmReachesServiceAndReportsSamplesConsumed) {
  FakeService service;
  App app(WithShapes());
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  const std::vector<float> values = Noise(3000, -1, 2);
  ASSERT_EQ(Apply(app, app.right, Pcm(values, 1000, false)), XR_SUCCESS);
  EXPECT_EQ(consumed_, 3000u);
  ASSERT_TRUE(HasWaveforms(service, 1));
  EXPECT_EQ(service.heard().waveforms[0].samples, values);
  EXPECT_EQ(service.heard().waveforms[0].waveform.sample_rate_Hz, 1000);
  EXPECT_EQ(service.heard().waveforms[0].waveform.append, 0u);

  ASSERT_EQ(Apply(app, app.right, Pcm(values, 1000, true)), XR_SUCCESS);
  EXPECT_GE(consumed_, 1000u) << "four seconds fit";
  EXPECT_LT(consumed_, 3000u);
  ASSERT_TRUE(HasWaveforms(service, 2));
  const Heard::Shaped second = service.heard().waveforms[1];
  EXPECT_EQ(second.waveform.append, 1u);
  EXPECT_EQ(second.samples, std::vector<float>(values.begin(), values.begin() + consumed_));

  ASSERT_EQ(Apply(app, app.right, Pcm(values, 1000, false)), XR_SUCCESS);
  EXPECT_EQ(consumed_, 3000u) << "without append the previous samples are replaced";
  ASSERT_TRUE(HasWaveforms(service, 3));
  EXPECT_EQ(service.heard().waveforms[2].waveform.append, 0u);
}

// [XR_FB_haptic_pcm] Append after another kind of effect, or after a stop, restarts.
TEST_F(Vibrations, AppendRestartsWhenNoPcmIsPlaying) {
  FakeService service;
  App app(WithShapes());
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  const std::vector<float> values = Noise(2000, -1, 3);
  ASSERT_EQ(Apply(app, app.right, Pcm(values, 1000, true)), XR_SUCCESS);
  ASSERT_EQ(app.Vibrate(app.right, 0.5f), XR_SUCCESS);
  ASSERT_EQ(Apply(app, app.right, Pcm(values, 1000, true)), XR_SUCCESS);
  const XrHapticActionInfo info{XR_TYPE_HAPTIC_ACTION_INFO, nullptr, app.haptic, app.right};
  ASSERT_EQ(xrStopHapticFeedback(app.session, &info), XR_SUCCESS);
  ASSERT_EQ(Apply(app, app.right, Pcm(values, 1000, true)), XR_SUCCESS);
  EXPECT_EQ(consumed_, 2000u);
  ASSERT_TRUE(HasWaveforms(service, 3));
  for (const Heard::Shaped& heard : service.heard().waveforms) EXPECT_EQ(heard.waveform.append, 0u);
}

TEST_F(Vibrations, InvalidVibrationsAreRejectedAndNotSent) {
  FakeService service;
  App app(WithShapes());
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  const std::vector<float> good{0.5f, 1.0f};
  const std::vector<float> bad{0.5f, std::numeric_limits<float>::quiet_NaN()};
  const std::vector<float> none;
  EXPECT_EQ(Apply(app, app.right, Envelope(bad, 1'000'000)), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(Apply(app, app.right, Envelope(none, 1'000'000)), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(Apply(app, app.right, Envelope(good, -2)), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(Apply(app, app.right, Pcm(bad, 1000, false)), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(Apply(app, app.right, Pcm(none, 1000, false)), XR_ERROR_VALIDATION_FAILURE);
  for (const float rate : {0.0f, -1.0f, std::numeric_limits<float>::quiet_NaN(), 1e9f}) {
    EXPECT_EQ(Apply(app, app.right, Pcm(good, rate, false)), XR_ERROR_VALIDATION_FAILURE) << rate;
  }
  XrHapticPcmVibrationFB no_pointer = Pcm(good, 1000, false);
  no_pointer.samplesConsumed = nullptr;
  EXPECT_EQ(Apply(app, app.right, no_pointer), XR_ERROR_VALIDATION_FAILURE);
  ASSERT_EQ(Apply(app, app.right, Envelope({3.0f, -3.0f}, 1'000'000)), XR_SUCCESS) << "clamped, not refused";
  ASSERT_TRUE(HasWaveforms(service, 1));
  EXPECT_EQ(service.heard().waveforms[0].samples, (std::vector<float>{1, 0}));
}

// The other hand belongs to a runtime without the extension: its device gets a plain vibration of the same length and
// strength, also where the pen is among the devices.
TEST_F(Vibrations, RuntimeWithoutExtensionsGetsPlainVibration) {
  FakeService service;
  App app(WithShapes());
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  const std::vector<float> values{0.5f, 1.0f};
  ASSERT_EQ(Apply(app, app.left, Envelope(values, 3'000'000)), XR_SUCCESS);
  EXPECT_EQ(Device("left").count, 1u);
  EXPECT_EQ(Device("left").last_duration_ns, 3'000'000);
  EXPECT_FLOAT_EQ(Device("left").last_amplitude, 0.75f);
  const std::vector<float> square(200, -0.4f);
  ASSERT_EQ(Apply(app, app.left, Pcm(square, 1000, false)), XR_SUCCESS);
  EXPECT_EQ(consumed_, 200u);
  EXPECT_EQ(Device("left").last_duration_ns, 200'000'000);
  EXPECT_FLOAT_EQ(Device("left").last_amplitude, 0.4f * std::sqrt(2.0f));
  EXPECT_TRUE(service.heard().waveforms.empty());

  ASSERT_EQ(Apply(app, XR_NULL_PATH, Envelope(values, 1'000'000)), XR_SUCCESS);
  ASSERT_TRUE(HasWaveforms(service, 1));
  EXPECT_EQ(Device("left").count, 3u);
  EXPECT_EQ(Device("right").count, 0u);
  EXPECT_EQ(Rate(app, app.right), 1000);
  EXPECT_EQ(Rate(app, XR_NULL_PATH), 1000);
  EXPECT_EQ(Rate(app, app.left), 0);

  const std::vector<float> none;
  EXPECT_EQ(Apply(app, app.left, Envelope(none, 1'000'000)), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(Apply(app, app.left, Pcm(none, 1000, false)), XR_ERROR_VALIDATION_FAILURE);
}

// A runtime that has them plays them itself on its own devices; PCM for both counts the samples that both have taken.
TEST_F(Vibrations, RuntimeWithExtensionsPlaysShapedVibration) {
  omni_test_offer_shapes(1);
  FakeService service;
  App app(WithShapes());
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  const std::vector<float> values(1500, 0.5f);
  ASSERT_EQ(Apply(app, app.left, Envelope(values, 3'000'000)), XR_SUCCESS);
  EXPECT_EQ(Device("left").envelopes, 1u);
  EXPECT_EQ(Device("left").last_samples, 1500u);
  ASSERT_EQ(Apply(app, app.left, Pcm(values, 1000, false)), XR_SUCCESS);
  EXPECT_EQ(Device("left").pcms, 1u);
  EXPECT_EQ(consumed_, 1000u) << "as the runtime says";
  EXPECT_TRUE(service.heard().waveforms.empty());
  EXPECT_EQ(Rate(app, app.left), 3000);
  EXPECT_EQ(Rate(app, app.right), 1000);

  ASSERT_EQ(Apply(app, app.right, Pcm(values, 1000, false)), XR_SUCCESS);
  EXPECT_EQ(consumed_, 1500u);
  ASSERT_EQ(Apply(app, XR_NULL_PATH, Pcm(values, 1000, false)), XR_SUCCESS);
  EXPECT_EQ(consumed_, 1000u);
  ASSERT_TRUE(HasWaveforms(service, 2));
  EXPECT_EQ(service.heard().waveforms[1].samples.size(), 1000u);
  EXPECT_EQ(Device("left").pcms, 2u);
  EXPECT_EQ(Device("right").pcms, 0u);
  EXPECT_EQ(Device("left").count, 0u);
}

TEST_F(Vibrations, SampleRateQueryRejectsInvalidArguments) {
  FakeService service;
  App app(WithShapes());
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  PFN_xrVoidFunction function = nullptr;
  ASSERT_EQ(xrGetInstanceProcAddr(app.instance, "xrGetDeviceSampleRateFB", &function), XR_SUCCESS);
  const auto get = reinterpret_cast<PFN_xrGetDeviceSampleRateFB>(function);
  XrDevicePcmSampleRateStateFB rate{XR_TYPE_DEVICE_PCM_SAMPLE_RATE_STATE_FB, nullptr, 0};
  XrHapticActionInfo info{XR_TYPE_HAPTIC_ACTION_INFO, nullptr, app.select, app.right};
  EXPECT_EQ(get(app.session, &info, &rate), XR_ERROR_ACTION_TYPE_MISMATCH);
  info.action = app.haptic;
  info.subactionPath = app.Path("/user/gamepad");
  EXPECT_EQ(get(app.session, &info, &rate), XR_ERROR_PATH_UNSUPPORTED);
  info.subactionPath = app.right;
  EXPECT_EQ(get(app.session, &info, nullptr), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(get(app.session, nullptr, &rate), XR_ERROR_VALIDATION_FAILURE);
  info.action = XR_NULL_HANDLE;
  EXPECT_EQ(get(app.session, &info, &rate), XR_ERROR_HANDLE_INVALID);
}

// [input-output-actions-haptics] Not focused: discarded, and playing vibrations stop.
TEST_F(Vibrations, LosingFocusDiscardsAndStopsVibrations) {
  FakeService service;
  App app(WithShapes());
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  ASSERT_EQ(Apply(app, app.right, Pcm(Noise(2000, -1, 4), 1000, false)), XR_SUCCESS);
  ASSERT_TRUE(HasWaveforms(service, 1));
  omni_test_set_focus(0);
  app.Poll();
  ASSERT_EQ(app.Sync(), XR_SESSION_NOT_FOCUSED);
  const std::vector<float> values = Noise(100, -1, 4);
  for (const XrPath hand : {app.right, app.left, XrPath{XR_NULL_PATH}}) {
    EXPECT_EQ(Apply(app, hand, Pcm(values, 1000, true)), XR_SESSION_NOT_FOCUSED);
    EXPECT_EQ(consumed_, 0u);
    EXPECT_EQ(Apply(app, hand, Envelope(values, 1'000'000)), XR_SESSION_NOT_FOCUSED);
  }
  EXPECT_EQ(Apply(app, app.Path("/user/gamepad"), Pcm(values, 1000, true)), XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(Apply(app, app.right, Envelope({}, 1'000'000)), XR_ERROR_VALIDATION_FAILURE);
  for (int i = 0; i < 500 && service.heard().haptic_stops == 0; ++i) {
    const timespec pause{0, 2'000'000};
    nanosleep(&pause, nullptr);
  }
  EXPECT_EQ(service.heard().haptic_stops, 1);
  EXPECT_EQ(service.heard().waveforms.size(), 1u);
}

TEST_F(Vibrations, ShapedVibrationsNeedTheExtensions) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  const std::vector<float> values{0.5f};
  EXPECT_EQ(Apply(app, app.right, Envelope(values, 1'000'000)), XR_ERROR_VALIDATION_FAILURE);
  PFN_xrVoidFunction function = nullptr;
  EXPECT_EQ(xrGetInstanceProcAddr(app.instance, "xrGetDeviceSampleRateFB", &function), XR_ERROR_FUNCTION_UNSUPPORTED);
  EXPECT_TRUE(service.heard().waveforms.empty());
}

// The service's buffer of four seconds never overflows, and is never left unfilled while there are more samples.
TEST(PcmBacklog, AcceptsAsMuchAsTheBufferHolds) {
  std::mt19937 random(6);
  layer::PcmBacklog backlog;
  const auto action = reinterpret_cast<XrAction>(std::uintptr_t{1});
  double end_s = 0;
  std::int64_t now_ns = 1'000'000'000;
  for (int i = 0; i < 5000; ++i) {
    layer::ShapedVibration pcm;
    pcm.waveform.sample_rate_Hz = std::array<float, 4>{100, 1000, 8000, 48000}[random() % 4];
    pcm.waveform.append = 1;
    pcm.samples.resize(1 + random() % 4000);
    bool continues = false;
    const double now_s = 1e-9 * static_cast<double>(now_ns);
    const std::uint32_t taken = backlog.ReserveSamples(action, pcm, now_ns, continues);
    const double rate_Hz = static_cast<double>(pcm.waveform.sample_rate_Hz);
    EXPECT_EQ(continues, end_s > now_s + 1e-9) << i;
    end_s = std::max(end_s, now_s) + taken / rate_Hz;
    ASSERT_LE(end_s - now_s, protocol::kWaveformBuffer_s + 1e-6) << i;
    if (taken < pcm.samples.size()) {
      ASSERT_GT(end_s - now_s, protocol::kWaveformBuffer_s - 1.01 / rate_Hz - 1e-6) << "room was left, " << i;
    }
    now_ns += static_cast<std::int64_t>(random() % 1'000'000'000);
  }
}

}  // namespace test_vibrations
}  // namespace omni::test
