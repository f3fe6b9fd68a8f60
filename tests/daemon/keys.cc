// Keyboards and pedals: what their bytes mean, unplugging, and a thread that reads pipes in place of devices.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <random>
#include <thread>

#include "service/base/clock.h"
#include "service/daemon/keys/key_thread.h"

namespace omni::daemon {
namespace test_daemon_keys {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

input_event Event(std::uint16_t type, std::uint16_t code, std::int32_t value, std::int64_t t_ns) {
  input_event event{};
  event.input_event_sec = static_cast<decltype(event.input_event_sec)>(t_ns / kSecond_ns);
  event.input_event_usec = static_cast<decltype(event.input_event_usec)>(t_ns % kSecond_ns / 1000);
  event.type = type;
  event.code = code;
  event.value = value;
  return event;
}

std::vector<unsigned char> Bytes(const std::vector<input_event>& events) {
  const auto* bytes = reinterpret_cast<const unsigned char*>(events.data());
  return {bytes, bytes + events.size() * sizeof(input_event)};
}

struct Heard {
  std::uint16_t code;
  bool down;
  std::int64_t t_ns;
  bool operator==(const Heard&) const = default;
};

std::vector<Heard> Decode(KeyDecoder& decoder, const std::vector<unsigned char>& bytes, std::int64_t now_ns) {
  std::vector<Heard> heard;
  decoder.Feed(bytes.data(), bytes.size(), now_ns, [&](std::uint16_t code, bool down, std::int64_t t_ns) {
    heard.push_back({code, down, t_ns});
  });
  return heard;
}

TEST(KeyDecoder, ReportsPressAndReleaseWithKernelTimes) {
  KeyDecoder decoder;
  const std::int64_t now = 100 * kSecond_ns;
  const auto heard =
      Decode(decoder,
             Bytes({Event(EV_MSC, MSC_SCAN, 5, now), Event(EV_KEY, KEY_B, 1, now - 3000),
                    Event(EV_SYN, SYN_REPORT, 0, now), Event(EV_KEY, KEY_B, 2, now), Event(EV_KEY, KEY_B, 0, now)}),
             now);
  EXPECT_EQ(heard, (std::vector<Heard>{{KEY_B, true, now - 3000}, {KEY_B, false, now}}));
}

TEST(KeyDecoder, DecodesEventsSplitAtAnyByte) {
  const std::int64_t now = 100 * kSecond_ns;
  std::vector<input_event> events;
  for (int i = 0; i < 50; ++i) events.push_back(Event(EV_KEY, KEY_A, i % 2 == 0, now - 1'000'000 * (50 - i)));
  const std::vector<unsigned char> bytes = Bytes(events);
  KeyDecoder whole;
  const std::vector<Heard> expected = Decode(whole, bytes, now);
  std::mt19937 random(3);
  for (int round = 0; round < 50; ++round) {
    KeyDecoder decoder;
    std::vector<Heard> heard;
    for (std::size_t at = 0; at < bytes.size();) {
      const std::size_t n = std::min<std::size_t>(1 + random() % 60, bytes.size() - at);
      const std::vector<unsigned char> part(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                                            bytes.begin() + static_cast<std::ptrdiff_t>(at + n));
      for (const Heard& h : Decode(decoder, part, now)) heard.push_back(h);
      at += n;
    }
    ASSERT_EQ(heard, expected) << round;
  }
}

TEST(KeyDecoder, ReplacesTimesOfOtherClocksByNow) {
  KeyDecoder decoder;
  const std::int64_t now = 100 * kSecond_ns;
  for (const std::int64_t strange :
       {now + 1'000'000, now - 2 * kSecond_ns, std::int64_t{0}, 1'700'000'000 * kSecond_ns}) {
    const auto heard = Decode(decoder, Bytes({Event(EV_KEY, KEY_A, 1, strange)}), now);
    ASSERT_EQ(heard.size(), 1u);
    EXPECT_EQ(heard[0].t_ns, now) << strange;
  }
}

TEST(KeyDecoder, SkipsAndReportsDroppedEvents) {
  KeyDecoder decoder;
  const std::int64_t now = 100 * kSecond_ns;
  auto heard = Decode(decoder, Bytes({Event(EV_SYN, SYN_DROPPED, 0, now), Event(EV_KEY, KEY_A, 1, now)}), now);
  EXPECT_TRUE(heard.empty());
  EXPECT_FALSE(decoder.PopDropped()) << "the report has not ended";
  heard = Decode(decoder, Bytes({Event(EV_SYN, SYN_REPORT, 0, now), Event(EV_KEY, KEY_A, 0, now)}), now);
  EXPECT_EQ(heard.size(), 1u);
  EXPECT_TRUE(decoder.PopDropped());
  EXPECT_FALSE(decoder.PopDropped());
}

// Random bytes: keys in range, sane times, consistent counts.
TEST(KeyBook, GarbageKeepsPressAndReleaseCountsConsistent) {
  std::mt19937 random(4);
  KeyBook book({KEY_A, KEY_B, 0, KEY_MAX});
  std::array<KeyDecoder, kMaxKeyDevicesOpen> decoders;
  std::int64_t now = 50 * kSecond_ns;
  std::uint64_t changes = 0;
  for (int i = 0; i < 20'000; ++i) {
    now += random() % 2'000'000;
    const int device = static_cast<int>(random() % 3);
    // Odd devices also send parts of events, after which all of their data is garbage.
    std::vector<unsigned char> bytes(device % 2 == 1 ? random() % 100 : sizeof(input_event) * (random() % 4));
    for (unsigned char& byte : bytes) byte = static_cast<unsigned char>(random());
    if (random() % 2 == 0) {  // mixed with valid events
      const std::uint16_t codes[] = {KEY_A, KEY_B, KEY_MAX, 0, 0xFFFF, KEY_C};
      const auto event = Event(EV_KEY, codes[random() % 6], static_cast<std::int32_t>(random() % 4) - 1, now);
      const auto sound = Bytes({event, Event(EV_SYN, SYN_REPORT, 0, now)});
      bytes = random() % 3 == 0 ? bytes : sound;
    }
    decoders[static_cast<std::size_t>(device)].Feed(bytes.data(), bytes.size(), now,
                                                    [&](std::uint16_t code, bool down, std::int64_t t_ns) {
                                                      EXPECT_LE(code, KEY_MAX);
                                                      EXPECT_LE(t_ns, now);
                                                      EXPECT_GE(t_ns, now - kSecond_ns);
                                                      changes += book.Set(device, code, down, t_ns) ? 1 : 0;
                                                    });
    if (random() % 100 == 0) book.ReleaseAll(device, now);
    for (const base::KeyState& key : book.states().slots) {
      ASSERT_LE(key.press_count - key.release_count, 1u);
    }
  }
  EXPECT_GT(changes, 50u) << "else this test tests nothing";
}

TEST(KeyBook, KeyStaysDownWhileAnyDeviceHoldsIt) {
  KeyBook book({KEY_A});
  const base::KeyState& key = book.states().slots[0];
  EXPECT_TRUE(book.Set(0, KEY_A, true, 10));
  EXPECT_FALSE(book.Set(1, KEY_A, true, 20));
  EXPECT_FALSE(book.Set(0, KEY_A, false, 30));
  EXPECT_EQ(key.release_count, 0u);
  EXPECT_TRUE(book.ReleaseAll(1, 40)) << "unplugged while it was held";
  EXPECT_EQ(key.press_count, 1u);
  EXPECT_EQ(key.release_count, 1u);
  EXPECT_EQ(key.t_press_ns, 10);
  EXPECT_EQ(key.t_release_ns, 40);
  EXPECT_FALSE(book.Set(0, KEY_B, true, 50)) << "a key that is not mapped";
}

// Devices that are pipes; the test holds their other ends.
class PipePorts : public KeyPorts {
 public:
  struct State {
    std::mutex mutex;
    std::map<std::string, int> writers;  // by path; other devices are absent
    std::map<std::string, bool> grabbed;
    std::string refusal;
    std::vector<bool> down;  // of all codes, after dropped events
    int opened = 0;
  };
  explicit PipePorts(State& state) : state_(state) {}

  std::vector<std::string> FindDevices(const config::KeyDeviceRule& rule) override {
    const std::lock_guard lock(state_.mutex);
    std::vector<std::string> paths;
    for (const auto& [path, writer] : state_.writers) {
      if (rule.path.empty() || rule.path == path) paths.push_back(path);
    }
    return paths;
  }
  base::Result<int> Open(const std::string& path, bool grab) override {
    const std::lock_guard lock(state_.mutex);
    if (!state_.refusal.empty()) return base::Error{path + ": " + state_.refusal};
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0) return base::Error{"pipe"};
    if (state_.writers[path] > 0) ::close(state_.writers[path]);
    state_.writers[path] = ends[1];
    state_.grabbed[path] = grab;
    ++state_.opened;
    return ends[0];
  }
  std::optional<std::vector<bool>> KeysDown(int, const std::vector<std::uint16_t>& codes) override {
    const std::lock_guard lock(state_.mutex);
    if (state_.down.size() != codes.size()) return std::nullopt;
    return state_.down;
  }

 private:
  State& state_;
};

class KeyThreadTest : public testing::Test {
 protected:
  ~KeyThreadTest() override {
    thread_.reset();
    for (const auto& [path, writer] : pipes_.writers) {
      if (writer > 0) ::close(writer);
    }
  }
  void Start(std::vector<config::KeyDeviceRule> rules) {
    thread_ = std::make_unique<KeyThread>(
        KeyThreadOptions{.devices = std::move(rules), .codes = {KEY_A, KEY_B}, .search_ms = 5},
        std::make_unique<PipePorts>(pipes_), [this](const base::KeyStates& states) {
          const std::lock_guard lock(mutex_);
          states_ = states;
        });
  }
  void Plug(const std::string& path) {
    const std::lock_guard lock(pipes_.mutex);
    pipes_.writers.emplace(path, 0);
  }
  void Unplug(const std::string& path) {
    const std::lock_guard lock(pipes_.mutex);
    ::close(pipes_.writers.at(path));
    pipes_.writers.erase(path);
  }
  void Send(const std::string& path, const std::vector<unsigned char>& bytes) {
    const std::lock_guard lock(pipes_.mutex);
    ASSERT_EQ(::write(pipes_.writers.at(path), bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  void SendKey(const std::string& path, std::uint16_t code, bool down) {
    Send(path, Bytes({Event(EV_KEY, code, down ? 1 : 0, base::MonotonicNow_ns())}));
  }
  base::KeyState Key(std::size_t slot) {
    const std::lock_guard lock(mutex_);
    return states_.slots[slot];
  }
  int Opened() {
    const std::lock_guard lock(pipes_.mutex);
    return pipes_.opened;
  }
  static bool Until(const std::function<bool()>& holds) {
    for (int i = 0; i < 2000; ++i) {
      if (holds()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }

  PipePorts::State pipes_;
  std::mutex mutex_;
  base::KeyStates states_;
  std::unique_ptr<KeyThread> thread_;
};

TEST_F(KeyThreadTest, ReportsKeysWithTheirTimes) {
  Plug("/pedal");
  Start({{.path = "/pedal", .name_glob = {}, .grab = false}});
  ASSERT_TRUE(Until([&] { return Opened() == 1; }));
  const std::int64_t before_ns = base::MonotonicNow_ns();
  SendKey("/pedal", KEY_B, true);
  ASSERT_TRUE(Until([&] { return Key(1).press_count == 1; }));
  EXPECT_GE(Key(1).t_press_ns, before_ns - 1000) << "to the microsecond";
  EXPECT_LE(Key(1).t_press_ns, base::MonotonicNow_ns());
  SendKey("/pedal", KEY_B, false);
  EXPECT_TRUE(Until([&] { return Key(1).release_count == 1; }));
  EXPECT_EQ(Key(0).press_count, 0u);
  EXPECT_FALSE(pipes_.grabbed["/pedal"]) << "only on request";
}

TEST_F(KeyThreadTest, UnplugReleasesKeysAndReplugResumes) {
  Start({{.path = "/pedal", .name_glob = {}, .grab = true}});
  ASSERT_TRUE(Until([&] { return !thread_->Status().empty() && thread_->Status()[0].paths.empty(); }));
  for (int round = 1; round <= 3; ++round) {
    Plug("/pedal");
    ASSERT_TRUE(Until([&] { return Opened() == round; })) << "found when it is there, round " << round;
    ASSERT_TRUE(Until([&] { return thread_->Status()[0].paths == "/pedal"; }));
    SendKey("/pedal", KEY_A, true);
    ASSERT_TRUE(Until([&] { return Key(0).press_count == static_cast<std::uint32_t>(round); }));
    Unplug("/pedal");
    ASSERT_TRUE(Until([&] { return Key(0).release_count == static_cast<std::uint32_t>(round); })) << "held no more";
  }
  EXPECT_TRUE(pipes_.grabbed["/pedal"]);
}

TEST_F(KeyThreadTest, GarbageFromOneDeviceDoesNotDisturbAnother) {
  Plug("/broken");
  Plug("/good");
  Start({{.path = {}, .name_glob = "*", .grab = false}});
  ASSERT_TRUE(Until([&] { return Opened() == 2; }));
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) {
    std::vector<unsigned char> bytes(1 + random() % 300);
    for (unsigned char& byte : bytes) byte = static_cast<unsigned char>(random());
    Send("/broken", bytes);
    if (i % 20 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  const std::uint32_t before = Key(0).press_count;
  SendKey("/good", KEY_A, true);
  EXPECT_TRUE(Until([&] { return Key(0).press_count == before + 1; }));
}

TEST_F(KeyThreadTest, QueriesKeyStateAfterDroppedEvents) {
  Plug("/pedal");
  pipes_.down = {false, true};
  Start({{.path = "/pedal", .name_glob = {}, .grab = false}});
  ASSERT_TRUE(Until([&] { return Opened() == 1; }));
  SendKey("/pedal", KEY_A, true);
  ASSERT_TRUE(Until([&] { return Key(0).press_count == 1; }));
  const std::int64_t now = base::MonotonicNow_ns();
  Send("/pedal", Bytes({Event(EV_SYN, SYN_DROPPED, 0, now), Event(EV_SYN, SYN_REPORT, 0, now)}));
  EXPECT_TRUE(Until([&] { return Key(0).release_count == 1 && Key(1).press_count == 1; }));
}

TEST_F(KeyThreadTest, StatusReportsWhyADeviceCannotBeOpened) {
  Plug("/pedal");
  pipes_.refusal = "cannot be opened (Permission denied)";
  Start({{.path = "/pedal", .name_glob = {}, .grab = false}});
  ASSERT_TRUE(Until([&] { return !thread_->Status()[0].problem.empty(); }));
  EXPECT_NE(thread_->Status()[0].problem.find("Permission denied"), std::string::npos);
  {
    const std::lock_guard lock(pipes_.mutex);
    pipes_.refusal.clear();
  }
  EXPECT_TRUE(Until([&] { return thread_->Status()[0].problem.empty() && thread_->Status()[0].paths == "/pedal"; }));
}

// The real ports, as far as they can be tested without a device: other files are rejected with a remedy.
TEST(EvdevPorts, RejectsFilesThatAreNotInputDevices) {
  const auto ports = MakeEvdevPorts();
  const auto null = ports->Open("/dev/null", false);
  ASSERT_FALSE(null.ok());
  EXPECT_NE(null.error().find("/dev/null: is not an input device"), std::string::npos) << null.error();
  EXPECT_NE(ports->Open("/no/such/device", false).error().find("inputs.toml"), std::string::npos);
  EXPECT_TRUE(ports->FindDevices({.path = "/no/such/device", .name_glob = {}, .grab = false}).empty());
  EXPECT_TRUE(ports->FindDevices({.path = {}, .name_glob = "no device has this name", .grab = false}).empty());
}

}  // namespace test_daemon_keys
}  // namespace omni::daemon
