// Checks of the control socket: what is accepted, and the errors of the rest.
#include "service/protocol/messages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "service/protocol/state_memory.h"
#include "service/protocol/surfaces/surface_memory.h"
#include "service/protocol/text.h"

namespace omni::protocol {
namespace test_protocol_validate_unit {

template <class T>
Message Check(const T& message) {
  return Validate(&message, sizeof(message));
}

template <class T>
std::string ReasonFor(const T& message) {
  const Message result = Check(message);
  const auto* invalid = std::get_if<Invalid>(&result);
  return invalid == nullptr ? "accepted" : invalid->reason;
}

Welcome GoodWelcome() {
  Welcome welcome;
  welcome.client_id = 7;
  welcome.state_bytes = sizeof(StateMemory);
  welcome.life_bytes = kLifePageBytes;
  return welcome;
}

template <class... M>
std::set<MessageType> TypesOf(std::variant<Invalid, M...>* /*tag*/) {
  return {Traits<M>::kType...};
}

// Each row of the table has a number of its own and stands in the variant of its direction.
TEST(MessageTable, RowsAreUniqueAndOfOneDirection) {
  const std::set<MessageType> client = TypesOf(static_cast<ClientMessage*>(nullptr));
  const std::set<MessageType> server = TypesOf(static_cast<ServerMessage*>(nullptr));
  EXPECT_EQ(client.size(), std::variant_size_v<ClientMessage> - 1);
  EXPECT_EQ(server.size(), std::variant_size_v<ServerMessage> - 1);
  EXPECT_EQ(client.size() + server.size(), std::variant_size_v<Message> - 1);
  EXPECT_EQ(std::variant_size_v<Request>, client.size() - 2) << "Hello and StatusRequest are the server's own";
  std::set<std::string> names;
  for (const MessageType type : client) {
    EXPECT_NE(RolesOf(type), 0U) << TypeName(type);
    EXPECT_TRUE(names.insert(TypeName(type)).second);
  }
  for (const MessageType type : server) {
    EXPECT_EQ(RolesOf(type), 0U) << TypeName(type);
    EXPECT_TRUE(names.insert(TypeName(type)).second);
  }
}

// A message whose size changes has another layout: an older peer would misread it. What a version has is frozen here;
// once the version is raised the rows are of a version that is gone, and those of the new one take their place when it
// is released.
TEST(MessageTable, SizesAreThoseOfTheVersion) {
  constexpr std::uint16_t kFrozen = 4;
  const std::map<std::string, std::size_t> frozen{{"Hello", 288},
                                                  {"StatusRequest", 16},
                                                  {"Session", 24},
                                                  {"Haptic", 32},
                                                  {"HapticStop", 16},
                                                  {"Waveform", 40},
                                                  {"EmergencyStop", 24},
                                                  {"SceneCommand", 160},
                                                  {"SurfaceRequest", 24},
                                                  {"ForceClaim", 24},
                                                  {"ForceApply", 64},
                                                  {"ForceConstraints", 1120},
                                                  {"ForceStop", 16},
                                                  {"HapticSceneLoad", 40},
                                                  {"HapticSceneEnd", 24},
                                                  {"HapticScenePlace", 144},
                                                  {"HapticSceneEnable", 24},
                                                  {"HapticNodes", 1824},
                                                  {"HapticMaterial", 112},
                                                  {"BasePoseRequest", 440},
                                                  {"SpaceChange", 88},
                                                  {"BasePoseCommand", 536},
                                                  {"Welcome", 40},
                                                  {"Reject", 272},
                                                  {"StatusReply", 16},
                                                  {"Notice", 1024},
                                                  {"SceneReply", 32},
                                                  {"Surfaces", 32},
                                                  {"ForceOwner", 24},
                                                  {"ForceProperties", 336},
                                                  {"HapticSceneState", 56},
                                                  {"HapticSceneTable", 32},
                                                  {"BasePose", 128},
                                                  {"BasePoseReply", 1024},
                                                  {"AppSettings", 152}};
#define OMNI_SIZE(name, ...) {#name, sizeof(name)},
  const std::map<std::string, std::size_t> sizes{OMNI_LINK_MESSAGES(OMNI_SIZE) OMNI_REQUESTS(OMNI_SIZE)
                                                     OMNI_SERVER_MESSAGES(OMNI_SIZE)};
#undef OMNI_SIZE
  std::string changed;
  for (const auto& [name, bytes] : frozen) {
    const auto now = sizes.find(name);
    if (now == sizes.end() || now->second != bytes) changed += name + " ";
  }
  EXPECT_TRUE(changed.empty() || kProtocolVersion > kFrozen)
      << changed << "changed: raise kProtocolVersion (service/protocol/control.h)";
  EXPECT_GE(kProtocolVersion, kFrozen);
}

TEST(MessageTable, AMessageOfTheOtherDirectionIsInvalid) {
  const Notice notice;
  const Session session;
  const ClientMessage of_client = ValidateFromClient(&notice, sizeof(notice));
  const ServerMessage of_server = ValidateFromServer(&session, sizeof(session));
  ASSERT_TRUE(std::holds_alternative<Invalid>(of_client) && std::holds_alternative<Invalid>(of_server));
  EXPECT_STREQ(std::get<Invalid>(of_client).reason, "Notice, a message that only omnid sends");
  EXPECT_STREQ(std::get<Invalid>(of_server).reason, "Session, a message that only clients send");
  EXPECT_TRUE(std::holds_alternative<Session>(ValidateFromClient(&session, sizeof(session))));
  EXPECT_TRUE(std::holds_alternative<Notice>(ValidateFromServer(&notice, sizeof(notice))));
}

TEST(Validate, AcceptsDefaultMessages) {
  EXPECT_TRUE(std::holds_alternative<Hello>(Check(Hello{})));
  EXPECT_TRUE(std::holds_alternative<Welcome>(Check(GoodWelcome())));
  EXPECT_TRUE(std::holds_alternative<Reject>(Check(Reject{})));
  EXPECT_TRUE(std::holds_alternative<Session>(Check(Session{})));
  EXPECT_TRUE(std::holds_alternative<Haptic>(Check(Haptic{})));
  EXPECT_TRUE(std::holds_alternative<HapticStop>(Check(HapticStop{})));
  EXPECT_TRUE(std::holds_alternative<StatusRequest>(Check(StatusRequest{})));
  EXPECT_TRUE(std::holds_alternative<Notice>(Check(Notice{})));
  EXPECT_TRUE(std::holds_alternative<SurfaceRequest>(Check(SurfaceRequest{})));
  EXPECT_TRUE(std::holds_alternative<EmergencyStop>(Check(EmergencyStop{})));
  EXPECT_TRUE(std::holds_alternative<Surfaces>(Check(Surfaces{})));
  EXPECT_TRUE(std::holds_alternative<SceneCommand>(Check(SceneCommand{})));
  EXPECT_TRUE(std::holds_alternative<SceneAnswer>(Check(SceneReply{})));
}

TEST(Validate, RejectsBasePosesOutOfRange) {
  const auto refused = [](auto message, auto change, const char* why) {
    EXPECT_EQ(ReasonFor(message), "accepted");
    change(message);
    EXPECT_NE(ReasonFor(message).find(why), std::string::npos) << ReasonFor(message);
  };
  BasePoseRequest request;
  request.space_count = 1;
  refused(
      request, [](BasePoseRequest& r) { r.space_count = 0; }, "space_count");
  refused(
      request, [](BasePoseRequest& r) { r.space_count = 9; }, "space_count");
  refused(
      request, [](BasePoseRequest& r) { std::memset(r.headset.system, 'x', sizeof(r.headset.system)); }, "system");
  refused(
      BasePose{},
      [](BasePose& p) {
        p.base_space.orientation_wxyz = {0, 0, 0, 0};
      },
      "unit quaternion");
  refused(
      BasePose{}, [](BasePose& p) { p.base_space.position_m[1] = std::nan(""); }, "within 100 m");
  refused(
      BasePose{}, [](BasePose& p) { p.expected_error_m = -1; }, "expected_error_m");
  refused(
      BasePose{}, [](BasePose& p) { p.doubtful = 2; }, "doubtful");
  SpaceChange change;
  change.pose_valid = 1;
  refused(
      change, [](SpaceChange& c) { c.pose_valid = 2; }, "pose_valid");
  refused(
      change, [](SpaceChange& c) { c.new_in_previous.position_m[0] = 101; }, "within 100 m");
  refused(
      BasePoseCommand{}, [](BasePoseCommand& c) { c.action = static_cast<BasePoseAction>(6); }, "action");
  refused(
      BasePoseCommand{}, [](BasePoseCommand& c) { c.rms_m = std::nan(""); }, "rms_m");
  refused(
      BasePoseCommand{}, [](BasePoseCommand& c) { std::memset(c.method, 'x', sizeof(c.method)); }, "method");
  refused(
      BasePose{}, [](BasePose& p) { p.follows = 2; }, "follows");
  refused(
      BaseMotion{}, [](BaseMotion& m) { m.state = static_cast<BaseState>(3); }, "state");
  refused(
      BaseMotion{}, [](BaseMotion& m) { m.t_ns = -1; }, "t_ns");
  refused(
      BaseMotion{}, [](BaseMotion& m) { m.base_space.position_m[2] = 101; }, "within 100 m");
  refused(
      BaseMotion{}, [](BaseMotion& m) { m.linear_velocity_m_s[1] = std::nan(""); }, "linear_velocity_m_s");
  refused(
      BaseMotion{}, [](BaseMotion& m) { m.angular_velocity_rad_s[1] = -101; }, "angular_velocity_rad_s");
  refused(
      BaseMotion{}, [](BaseMotion& m) { std::memset(m.headset.system, 'x', sizeof(m.headset.system)); }, "system");
  refused(
      BasePoseReply{}, [](BasePoseReply& r) { r.done = 2; }, "done");
}

// A waveform with these samples behind it.
std::string WaveformPacket(Waveform waveform, const std::vector<float>& samples) {
  waveform.count = static_cast<std::uint32_t>(samples.size());
  waveform.header.size = static_cast<std::uint32_t>(sizeof(waveform) + samples.size() * sizeof(float));
  std::string packet(reinterpret_cast<const char*>(&waveform), sizeof(waveform));
  packet.append(reinterpret_cast<const char*>(samples.data()), samples.size() * sizeof(float));
  return packet;
}

std::string WaveformProblem(const Waveform& waveform, const std::vector<float>& samples) {
  const std::string packet = WaveformPacket(waveform, samples);
  const Message message = Validate(packet.data(), packet.size());
  const auto* invalid = std::get_if<Invalid>(&message);
  return invalid == nullptr ? "accepted" : invalid->reason;
}

Waveform Pcm() {
  Waveform waveform;
  waveform.kind = WaveformKind::kPcm;
  waveform.sample_rate_Hz = 8000;
  return waveform;
}

TEST(Validate, AcceptsWaveformsWithTheirSamples) {
  const std::vector<float> samples{0, 0.25F, 1};
  const std::string packet = WaveformPacket(Waveform{}, samples);
  const Message message = Validate(packet.data(), packet.size());
  const auto* shaped = std::get_if<ShapedHaptic>(&message);
  ASSERT_NE(shaped, nullptr);
  ASSERT_EQ(shaped->waveform.count, 3u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(shaped->sample(i), samples[i]);
  EXPECT_EQ(WaveformProblem(Pcm(), {-1, 1}), "accepted");
  EXPECT_EQ(WaveformProblem(Waveform{}, std::vector<float>(kMaxWaveformSamples, 1)), "accepted");
}

TEST(Validate, RejectsWaveformsOutOfRange) {
  const auto expect = [](const Waveform& waveform, const std::vector<float>& samples, const char* words) {
    EXPECT_NE(WaveformProblem(waveform, samples).find(words), std::string::npos) << WaveformProblem(waveform, samples);
  };
  expect(Waveform{}, {}, "count");
  expect(Waveform{}, std::vector<float>(kMaxWaveformSamples + 1, 1), "count");
  expect(Waveform{}, {0, std::numeric_limits<float>::quiet_NaN()}, "sample 1");
  expect(Waveform{}, {-0.5F}, "sample 0");
  expect(Pcm(), {0, -1.5F}, "sample 1");
  expect(Pcm(), {std::numeric_limits<float>::infinity()}, "sample 0");
  for (const float rate_Hz : {0.0F, -1.0F, 2e5F, std::numeric_limits<float>::quiet_NaN()}) {
    Waveform waveform = Pcm();
    waveform.sample_rate_Hz = rate_Hz;
    expect(waveform, {0}, "sample_rate_Hz");
  }
  Waveform waveform;
  waveform.duration_ns = -2;
  expect(waveform, {0}, "duration_ns");
  waveform = Pcm();
  waveform.append = 2;
  expect(waveform, {0}, "append");
  waveform = Waveform{};
  waveform.append = 1;
  expect(waveform, {0}, "append");
  waveform.kind = static_cast<WaveformKind>(3);
  expect(waveform, {0}, "kind");
  const std::string whole = WaveformPacket(Waveform{}, {0, 1});
  std::string cut = whole;
  cut.resize(cut.size() - 4);
  const auto size = static_cast<std::uint32_t>(cut.size());
  std::memcpy(cut.data() + offsetof(MessageHeader, size), &size, sizeof(size));
  const Message message = Validate(cut.data(), cut.size());
  EXPECT_TRUE(std::holds_alternative<Invalid>(message)) << "two samples announced, one there";
}

TEST(Validate, SceneAnswerHoldsTheReplyAndItsText) {
  SceneReply reply;
  const std::string text = "clay: nothing to undo";
  reply.number = 7;
  reply.header.size = static_cast<std::uint32_t>(sizeof(reply) + text.size());
  std::string packet(reinterpret_cast<const char*>(&reply), sizeof(reply));
  packet += text;
  const Message message = Validate(packet.data(), packet.size());
  ASSERT_TRUE(std::holds_alternative<SceneAnswer>(message));
  EXPECT_EQ(std::get<SceneAnswer>(message).text, text);
  EXPECT_EQ(std::get<SceneAnswer>(message).reply.number, 7u);
  reply.header.size = sizeof(reply) - 1;
  const Message cut = Validate(&reply, sizeof(reply) - 1);
  EXPECT_NE(std::string(std::get<Invalid>(cut).reason).find("at least 32"), std::string::npos);
}

TEST(Validate, RejectsSceneMessagesOutOfRange) {
  SceneCommand command;
  command.action = static_cast<SceneAction>(0);
  EXPECT_NE(ReasonFor(command).find("action"), std::string::npos);
  command.action = static_cast<SceneAction>(6);
  EXPECT_NE(ReasonFor(command).find("action"), std::string::npos);
  command = {};
  std::memset(command.object, 'x', sizeof(command.object));
  EXPECT_NE(ReasonFor(command).find("object"), std::string::npos);
  SceneReply reply;
  reply.done = 2;
  EXPECT_NE(ReasonFor(reply).find("done"), std::string::npos);
  reply = {};
  reply.file_bytes = 1;
  EXPECT_NE(ReasonFor(reply).find("refusal with a file"), std::string::npos);
}

TEST(Validate, KeepsTheFields) {
  Hello hello;
  hello.role = ClientRole::kMonitor;
  SetField(hello.application, "touch");
  hello.api_version_minor = 1;
  const Message message = Check(hello);
  const auto* same = std::get_if<Hello>(&message);
  ASSERT_NE(same, nullptr);
  EXPECT_EQ(same->role, ClientRole::kMonitor);
  EXPECT_STREQ(same->application, "touch");
  EXPECT_EQ(same->api_version_minor, 1u);
}

TEST(Validate, StatusReplyHoldsTheTextAfterTheHeader) {
  const std::string json = R"({"clients":[]})";
  MessageHeader header;
  header.type = MessageType::kStatusReply;
  header.size = static_cast<std::uint32_t>(sizeof(header) + json.size());
  std::string packet(reinterpret_cast<const char*>(&header), sizeof(header));
  packet += json;
  const Message message = Validate(packet.data(), packet.size());
  ASSERT_TRUE(std::holds_alternative<StatusReply>(message));
  EXPECT_EQ(std::get<StatusReply>(message).json, json);
}

TEST(Validate, RejectsInvalidHeaders) {
  Session session;
  const Message cut = Validate(&session, sizeof(MessageHeader) - 1);
  EXPECT_NE(std::string(std::get<Invalid>(cut).reason).find("shorter than a header"), std::string::npos);
  const Message none = Validate(nullptr, 0);
  EXPECT_TRUE(std::holds_alternative<Invalid>(none));
  session.header.magic ^= 1;
  EXPECT_NE(ReasonFor(session).find("magic"), std::string::npos);
  session = {};
  session.header.size += 8;
  EXPECT_NE(ReasonFor(session).find("header says"), std::string::npos);
  session = {};
  session.header.type = static_cast<MessageType>(99);
  EXPECT_NE(ReasonFor(session).find("unknown"), std::string::npos);
  session = {};
  session.header.type = MessageType::kNotice;
  EXPECT_NE(ReasonFor(session).find("Notice of 24 bytes"), std::string::npos);
  const std::vector<char> huge(kMaxMessageBytes + 1);
  EXPECT_NE(std::string(std::get<Invalid>(Validate(huge.data(), huge.size())).reason).find("limit"), std::string::npos);
}

TEST(Validate, ReportsOtherVersionsAsSuch) {
  Hello hello;
  hello.header.version = kProtocolVersion + 3;
  const Message message = Check(hello);
  const auto* invalid = std::get_if<Invalid>(&message);
  ASSERT_NE(invalid, nullptr);
  EXPECT_TRUE(invalid->other_version);
  EXPECT_EQ(invalid->version, kProtocolVersion + 3);
}

TEST(Validate, AcceptsRejectOfEveryVersion) {
  Reject reject;
  reject.header.version = kProtocolVersion + 1;
  reject.server_version = kProtocolVersion + 1;
  EXPECT_TRUE(std::holds_alternative<Reject>(Check(reject)));
}

TEST(Validate, RejectsEnumsOutOfRange) {
  Hello hello;
  hello.role = static_cast<ClientRole>(0);
  EXPECT_NE(ReasonFor(hello).find("role"), std::string::npos);
  hello.role = static_cast<ClientRole>(4);
  EXPECT_NE(ReasonFor(hello).find("role"), std::string::npos);
  Session session;
  session.state = static_cast<SessionState>(3);
  EXPECT_NE(ReasonFor(session).find("state"), std::string::npos);
  Notice notice;
  notice.level = 3;
  EXPECT_NE(ReasonFor(notice).find("level"), std::string::npos);
}

TEST(Validate, RejectsUnterminatedText) {
  Hello hello;
  std::memset(hello.application, 'x', sizeof(hello.application));
  EXPECT_NE(ReasonFor(hello).find("application"), std::string::npos);
  hello = {};
  std::memset(hello.engine, 'x', sizeof(hello.engine));
  EXPECT_NE(ReasonFor(hello).find("engine"), std::string::npos);
  Reject reject;
  std::memset(reject.reason, 'x', sizeof(reject.reason));
  EXPECT_NE(ReasonFor(reject).find("reason"), std::string::npos);
  Notice notice;
  std::memset(notice.text, 'x', sizeof(notice.text));
  EXPECT_NE(ReasonFor(notice).find("text"), std::string::npos);
}

TEST(Validate, RejectsHapticsOutOfRange) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinite = std::numeric_limits<float>::infinity();
  const std::function<void(Haptic&)> faults[] = {
      [&](Haptic& h) { h.amplitude = nan; },         [&](Haptic& h) { h.amplitude = 1.01f; },
      [&](Haptic& h) { h.amplitude = -0.01f; },      [&](Haptic& h) { h.frequency_Hz = nan; },
      [&](Haptic& h) { h.frequency_Hz = infinite; }, [&](Haptic& h) { h.frequency_Hz = -1; },
      [&](Haptic& h) { h.duration_ns = -2; },
  };
  for (const auto& spoil : faults) {
    Haptic haptic{.duration_ns = 1'000'000, .amplitude = 0.5f, .frequency_Hz = 200};
    EXPECT_EQ(ReasonFor(haptic), "accepted");
    spoil(haptic);
    EXPECT_NE(ReasonFor(haptic), "accepted");
  }
  Haptic endless{.duration_ns = std::numeric_limits<std::int64_t>::max(), .amplitude = 1, .frequency_Hz = 0};
  EXPECT_EQ(ReasonFor(endless), "accepted");
}

TEST(Validate, RejectsWelcomeWithWrongMemorySizes) {
  Welcome welcome = GoodWelcome();
  welcome.client_id = 0;
  EXPECT_NE(ReasonFor(welcome).find("client_id"), std::string::npos);
  welcome = GoodWelcome();
  welcome.state_bytes -= 1;
  EXPECT_NE(ReasonFor(welcome).find("state_bytes"), std::string::npos);
  welcome = GoodWelcome();
  welcome.life_bytes = 1 << 30;
  EXPECT_NE(ReasonFor(welcome).find("life_bytes"), std::string::npos);
}

TEST(Validate, RejectsAnEmergencyStopThatIsNeitherOnNorOff) {
  EmergencyStop stop;
  stop.on = 2;
  EXPECT_NE(ReasonFor(stop).find("on is neither"), std::string::npos);
}

TEST(Validate, RejectsContradictorySurfaces) {
  SurfaceRequest request;
  request.wanted = 2;
  EXPECT_NE(ReasonFor(request).find("wanted"), std::string::npos);
  Surfaces surfaces;
  surfaces.total_bytes = kMaxSurfaceBytes;
  EXPECT_NE(ReasonFor(surfaces).find("memory_generation"), std::string::npos);
  surfaces.memory_generation = 1;
  EXPECT_EQ(ReasonFor(surfaces), "accepted");
  surfaces.total_bytes += 1;
  EXPECT_NE(ReasonFor(surfaces).find("total_bytes"), std::string::npos);
  surfaces.total_bytes = 0;
  EXPECT_NE(ReasonFor(surfaces).find("memory_generation"), std::string::npos);
}

TEST(Validate, TypeNameNamesKnownAndUnknownTypes) {
  EXPECT_STREQ(TypeName(MessageType::kHapticStop), "HapticStop");
  EXPECT_STREQ(TypeName(static_cast<MessageType>(0)), "unknown");
}

}  // namespace test_protocol_validate_unit
}  // namespace omni::protocol
