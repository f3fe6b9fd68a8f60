// omni surfaces: what omnid publishes for drawing. Requests the surfaces as an application would, so that they are
// computed while it runs.
#include "service/tools/surfaces/surfaces.h"

#include <chrono>
#include <cmath>
#include <iostream>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "service/base/clock.h"
#include "service/client/connection.h"
#include "service/client/surface_reader.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/output.h"
#include "service/tools/common/terminal.h"

namespace omni::tools {
namespace {

using client::SurfaceCopy;
using client::SurfaceRead;
using client::SurfaceReader;

constexpr auto kReadPeriod = std::chrono::milliseconds(4);  // more often than the service publishes
constexpr std::int64_t kRatePeriod_ns = 1'000'000'000;
constexpr std::int64_t kAnswerTime_ns = 2'500'000'000;

struct SurfacesArguments {
  std::string socket;
  bool watch = false, as_json = false;
  double seconds = std::numeric_limits<double>::infinity();
  SurfacesSaveArguments save;  // but for socket and seconds
};

double LengthOf(const std::array<double, 3>& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

// Keeps the connection, reads every object, counts what is new over whole seconds.
class SurfaceCounter {
 public:
  explicit SurfaceCounter(const std::string& socket)
      : connection_({.role = protocol::ClientRole::kMonitor,
                     .application = "omni surfaces",
                     .engine = "",
                     .socket_path = socket}) {
    connection_.RequestSurfaces(true);
  }

  // True: new rates are available, or something else to show.
  bool Read(std::int64_t now_ns) {
    connection_.Poll(now_ns);
    connection_.SignalAlive();
    view_.connected = connection_.connected();
    view_.problem = connection_.last_error();
    view_.answered = connection_.surfaces_answered();
    const auto reader = connection_.surfaces();
    const bool other = reader != reader_;
    if (other) Begin(reader, now_ns);
    if (reader_ == nullptr) return other;
    for (std::size_t i = 0; i < copies_.size(); ++i) {
      const SurfaceRead read = reader_->Read(i, copies_[i]);
      counts_[i] += read != SurfaceRead::kNothing && read != SurfaceRead::kUnchanged ? 1 : 0;
      Fill(copies_[i], view_.rows[i]);
    }
    if (now_ns - since_ns_ < kRatePeriod_ns) return other;
    CountRates(now_ns);
    return true;
  }

  const SurfacesView& view() const { return view_; }
  bool failed() const { return !view_.connected && !view_.problem.empty(); }

 private:
  void Begin(std::shared_ptr<const SurfaceReader> reader, std::int64_t now_ns) {
    reader_ = std::move(reader);
    view_.has_memory = reader_ != nullptr;
    view_.rows.clear();
    copies_.clear();
    since_ns_ = now_ns;
    poll_count_ = PollCount();
    if (reader_ == nullptr) return;
    view_.scene_generation = reader_->scene_generation();
    view_.memory_generation = reader_->memory_generation();
    view_.bytes = reader_->bytes();
    view_.poll_Hz = 0;
    copies_.resize(reader_->object_count());
    counts_.assign(reader_->object_count(), 0);
    for (std::size_t i = 0; i < reader_->object_count(); ++i) {
      view_.rows.push_back({.name = reader_->object(i).name, .flags = reader_->object(i).flags});
    }
  }

  static void Fill(const SurfaceCopy& copy, SurfaceRow& row) {
    row.vertices = copy.frame.vertex_count;
    row.triangles = copy.frame.triangle_count;
    row.largest_displacement_m = copy.frame.largest_displacement_m;
    row.translation_m = LengthOf(copy.frame.translation_m);
  }

  void CountRates(std::int64_t now_ns) {
    const double elapsed_s = static_cast<double>(now_ns - since_ns_) * 1e-9;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      view_.rows[i].changes_Hz = static_cast<double>(std::exchange(counts_[i], 0)) / elapsed_s;
    }
    const std::uint64_t poll_count = PollCount();
    view_.poll_Hz = static_cast<double>(poll_count - poll_count_) / elapsed_s;
    poll_count_ = poll_count;
    since_ns_ = now_ns;
  }

  std::uint64_t PollCount() const {
    protocol::SurfacePulse pulse;
    return reader_ != nullptr && reader_->ReadPulse(pulse) ? pulse.poll_count : 0;
  }

  client::Connection connection_;
  SurfacesView view_;
  std::shared_ptr<const SurfaceReader> reader_;
  std::vector<SurfaceCopy> copies_;  // of the objects
  std::vector<int> counts_;          // reads that brought something new
  std::int64_t since_ns_ = 0;
  std::uint64_t poll_count_ = 0;
};

int NoSurfaceService(const SurfacesArguments& arguments, const SurfaceCounter& counter) {
  const std::string path = arguments.socket.empty() ? client::DefaultSocketPath() : arguments.socket;
  const std::string& why = counter.view().problem;
  return FailWith(arguments.as_json, "omni surfaces",
                  (why.empty() ? "omnid does not answer at " + path : why) + "; to start it: `omnid --device twin`",
                  kExitNoService);
}

// Over one second.
int PrintSurfaces(const SurfacesArguments& arguments) {
  SurfaceCounter counter(arguments.socket);
  const std::int64_t begin_ns = base::MonotonicNow_ns();
  for (;;) {
    const std::int64_t now_ns = base::MonotonicNow_ns();
    counter.Read(now_ns);
    const SurfacesView& view = counter.view();
    if (counter.failed()) break;
    const bool counted = view.has_memory ? view.poll_Hz > 0 : view.answered;
    if (counted || now_ns - begin_ns > kAnswerTime_ns) break;
    std::this_thread::sleep_for(kReadPeriod);
  }
  if (!counter.view().connected) return NoSurfaceService(arguments, counter);
  if (!arguments.as_json) {
    std::cout << SurfacesText(counter.view());
    return kExitOk;
  }
  if (!counter.view().answered) return FailWith(true, "omni surfaces", "omnid has not answered in time; try again");
  PrintJson(SurfacesJson(counter.view()));
  return kExitOk;
}

int WatchSurfaces(const SurfacesArguments& arguments) {
  const EndSignals signals;
  SurfaceCounter counter(arguments.socket);
  std::unique_ptr<AlternateScreen> screen;
  if (CanDraw()) screen = std::make_unique<AlternateScreen>();
  const std::int64_t begin_ns = base::MonotonicNow_ns();
  bool was_connected = false;
  int reads = 0;
  std::string last;  // printed while there is nothing to count
  for (;;) {
    const std::int64_t now_ns = base::MonotonicNow_ns();
    if (EndSignals::asked() || static_cast<double>(now_ns - begin_ns) * 1e-9 >= arguments.seconds) break;
    const bool news = counter.Read(now_ns);
    was_connected |= counter.view().connected;
    const bool gone = screen != nullptr && ++reads % 25 == 0 && !screen->Show(SurfacesText(counter.view()));
    if (screen == nullptr && (counter.view().connected || counter.failed())) {
      const std::string text = SurfacesText(counter.view());
      const bool other_state = !counter.view().has_memory && text != last;
      if (news || other_state) std::cout << text << std::flush;
      last = text;
    }
    if (gone || !std::cout.good()) break;
    std::this_thread::sleep_for(kReadPeriod);
  }
  screen.reset();
  return was_connected ? kExitOk : NoSurfaceService(arguments, counter);
}

int Surfaces(const SurfacesArguments& arguments) {
  if (arguments.save.file.empty()) return arguments.watch ? WatchSurfaces(arguments) : PrintSurfaces(arguments);
  SurfacesSaveArguments save = arguments.save;
  save.socket = arguments.socket;
  if (std::isfinite(arguments.seconds)) save.seconds = arguments.seconds;
  return SaveSurfaces(save);
}

}  // namespace

void AddSurfaces(Command& app) {
  auto arguments = std::make_shared<SurfacesArguments>();
  SurfacesSaveArguments& save = arguments->save;
  Command surfaces = app.AddCommand("surfaces", "show the surfaces that are soft, sculpted, extruded or moved");
  Option watch = surfaces.Add("--watch", arguments->watch, "keep updating, until Ctrl-C");
  Option file =
      surfaces.Add("--save", save.file, "write the surfaces as they are now").WritesOnly(".glb", "binary glTF");
  file.Excludes(watch);
  surfaces.Add("--json", arguments->as_json, "as JSON").Excludes(watch).Excludes(file);
  surfaces
      .Add("--largest", save.largest,
           "--save: watch for --seconds and write the surfaces at their largest displacement")
      .Needs(file);
  surfaces.Add("--force", save.force, "--save: replace an existing file").Needs(file);
  surfaces
      .Add("--seconds", arguments->seconds,
           "--watch: stop after this many seconds; --largest: watch for so many (default 10)")
      .Positive();
  AddSocket(surfaces, arguments->socket);
  surfaces.SetAction(arguments, Surfaces);
}

}  // namespace omni::tools
