#include "tests/bench/layer/cost.h"

#include <dlfcn.h>
#include <malloc.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

namespace omni::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr XrDuration kFrameAhead_ns = 11'000'000;  // typical request of an application: the display time of its frame
constexpr XrDuration kPast_ns = 10'000'000;

// Functions that OpenXR 1.0.20's headers lack, as the registry has them (XR_KHR_locate_spaces).
struct SpacesLocateInfo {
  XrStructureType type;
  const void* next;
  XrSpace baseSpace;
  XrTime time;
  std::uint32_t spaceCount;
  const XrSpace* spaces;
};
struct SpaceLocationData {
  XrSpaceLocationFlags locationFlags;
  XrPosef pose;
};
struct SpaceLocations {
  XrStructureType type;
  void* next;
  std::uint32_t locationCount;
  SpaceLocationData* locations;
};
constexpr auto kSpacesLocateInfo = static_cast<XrStructureType>(1000471000);
constexpr auto kSpaceLocations = static_cast<XrStructureType>(1000471001);
using LocateSpacesFunction = XrResult(XRAPI_PTR*)(XrSession, const SpacesLocateInfo*, SpaceLocations*);

// What is timed. Names are what `omni-bench` shows.
struct Calls {
  explicit Calls(const App& the_app) : app(the_app), time(Now(the_app)) {}

  // Later calls request a pose so far ahead, or in the past.
  void Ahead(XrDuration ns) { time = Now(app) + ns; }

  void LocateRight() { xrLocateSpace(app.right, app.local, time, &location); }
  void LocateLeft() { xrLocateSpace(app.left, app.local, time, &location); }
  void PassThrough() { xrGetInstanceProperties(app.instance, &properties); }
  void PoseState() {
    const XrActionStateGetInfo info{XR_TYPE_ACTION_STATE_GET_INFO, nullptr, app.pose, app.right_path};
    xrGetActionStatePose(app.session, &info, &state);
  }
  void LocateBoth() {
    const XrSpace both[] = {app.right, app.left};
    const SpacesLocateInfo info{kSpacesLocateInfo, nullptr, app.local, time, 2, both};
    SpaceLocations out{kSpaceLocations, nullptr, 2, data};
    reinterpret_cast<LocateSpacesFunction>(app.locate_spaces)(app.session, &info, &out);
  }

  const App& app;
  XrTime time;
  XrSpaceLocation location{XR_TYPE_SPACE_LOCATION, nullptr, 0, {}};
  XrInstanceProperties properties{XR_TYPE_INSTANCE_PROPERTIES, nullptr, 0, {}};
  XrActionStatePose state{XR_TYPE_ACTION_STATE_POSE, nullptr, XR_FALSE};
  SpaceLocationData data[2];
};

constexpr const char* kLocatePen = "xrLocateSpace (pen)";
constexpr const char* kLocatePast = "xrLocateSpace (pen, 10 ms ago)";
constexpr const char* kLocateOther = "xrLocateSpace (other hand)";
constexpr const char* kPassThrough = "xrGetInstanceProperties (pass-through)";
constexpr const char* kPoseState = "xrGetActionStatePose";
constexpr const char* kLocateBoth = "xrLocateSpacesKHR (pen and other hand)";
constexpr const char* kSync = "xrSyncActions";

// How often the runtime below was called; -1: not counted.
class CallsBelow {
 public:
  explicit CallsBelow(const std::string& runtime) {
    if (runtime.empty()) return;
    if (void* library = dlopen(runtime.c_str(), RTLD_NOW | RTLD_NOLOAD))
      count_ = reinterpret_cast<long (*)(const char*)>(dlsym(library, "omni_test_call_count"));
  }
  long Of(const std::string& call) const { return count_ ? count_(call.substr(0, call.find(' ')).c_str()) : -1; }

 private:
  long (*count_)(const char*) = nullptr;
};

class Table {
 public:
  explicit Table(const CallsBelow& below) : below_(below) {}
  ~Table() { std::printf("%s]\n", first_ ? "[" : ""); }

  // Percentiles over batches of kPerBatch calls; `prepare` comes before each and is not timed.
  template <class Prepare, class Call>
  void Time(const char* name, Prepare prepare, Call call) {
    constexpr int kBatches = 3000;
    constexpr int kPerBatch = 64;
    prepare();
    for (int i = 0; i < kPerBatch; ++i) call();  // first touches
    std::vector<double> ns;
    const long before = below_.Of(name);
    for (int batch = 0; batch < kBatches; ++batch) {
      prepare();
      const Clock::time_point begin = Clock::now();
      for (int i = 0; i < kPerBatch; ++i) call();
      ns.push_back(std::chrono::duration<double, std::nano>(Clock::now() - begin).count() / kPerBatch);
    }
    const double calls = before < 0 ? -1 : static_cast<double>(below_.Of(name) - before) / (kBatches * kPerBatch);
    std::sort(ns.begin(), ns.end());
    std::printf("%s{\"call\": \"%s\", \"ns_median\": %.1f, \"ns_p99\": %.1f, \"below\": %.3f}", first_ ? "[" : ",\n",
                name, ns[ns.size() / 2], ns[ns.size() * 99 / 100], calls);
    first_ = false;
  }

 private:
  const CallsBelow& below_;
  bool first_ = true;
};

long HeapBytes() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<long>(info.uordblks + info.hblkhd);
}

// Of shared memory (memfd) that is mapped.
long MappedBytes() {
  long bytes = 0;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    unsigned long begin = 0;
    unsigned long end = 0;
    if (line.find("memfd:") != std::string::npos && std::sscanf(line.c_str(), "%lx-%lx", &begin, &end) == 2)
      bytes += static_cast<long>(end - begin);
  }
  return bytes;
}

}  // namespace

void TimeCalls(const App& app, const std::string& runtime) {
  Calls calls(app);
  const CallsBelow below(runtime);
  Table table(below);
  const auto ahead = [&] { calls.Ahead(kFrameAhead_ns); };
  table.Time(kLocatePen, ahead, [&] { calls.LocateRight(); });
  table.Time(
      kLocatePast, [&] { calls.Ahead(-kPast_ns); }, [&] { calls.LocateRight(); });
  table.Time(kLocateOther, ahead, [&] { calls.LocateLeft(); });
  if (app.locate_spaces) table.Time(kLocateBoth, ahead, [&] { calls.LocateBoth(); });
  table.Time(
      kPassThrough, [] {}, [&] { calls.PassThrough(); });
  table.Time(
      kPoseState, [] {}, [&] { calls.PoseState(); });
  table.Time(
      kSync, [] {}, [&] { Sync(app); });
}

void CountBetweenMarkers(const App& app, int times) {
  Calls calls(app);
  const auto repeat = [](int count, auto call) {
    for (int i = 0; i < count; ++i) call();
  };
  const auto all = [&](int count, auto mark) {
    repeat(count, [&] { calls.LocateRight(); });
    mark();
    repeat(count, [&] { calls.LocateLeft(); });
    mark();
    repeat(count, [&] { calls.PassThrough(); });
    mark();
  };
  all(10, [] {});  // lazy binding and first touches
  syscall(SYS_getppid);
  all(times, [] { syscall(SYS_getppid); });
}

void PrintMemory(bool pen) {
  const auto round = [pen](long bytes[3]) {
    App app;
    const long none = HeapBytes();
    CreateInstance(app);
    const long instance = HeapBytes();
    CreateSession(app);
    CreateActions(app);
    for (int i = 0; i < 10; ++i) Sync(app);
    if (pen) WaitForPen(app);
    bytes[0] = instance - none;
    bytes[1] = HeapBytes() - instance;
    bytes[2] = MappedBytes();
    xrDestroyInstance(app.instance);
  };
  long bytes[3];
  round(bytes);  // what is made once per process
  round(bytes);
  std::printf("{\"instance_bytes\": %ld, \"session_bytes\": %ld, \"mapped_bytes\": %ld}\n", bytes[0], bytes[1],
              bytes[2]);
}

}  // namespace omni::bench
