#include "service/daemon/clients/status.h"

#include <unistd.h>

#include <cmath>

#include <nlohmann/json.hpp>

#include "firmware/wire/names.h"
#include "service/base/threads/realtime_threads.h"
#include "service/base/vec.h"
#include "service/config/inputs/input_table.h"
#include "service/daemon/devices/open_device.h"

namespace omni::daemon {
namespace {

using nlohmann::json;

const char* SessionName(protocol::SessionState state) {
  switch (state) {
    case protocol::SessionState::kBegun:
      return "begun";
    case protocol::SessionState::kFocused:
      return "focused";
    case protocol::SessionState::kNone:
      break;
  }
  return "none";
}

json FaultNames(std::uint32_t faults) {
  json names = json::array();
  for (const wire::FaultText& fault : wire::FaultTexts()) {
    if ((faults & fault.fault) != 0) names.push_back(fault.name);
  }
  return names;
}

json Device(const AttachedDevice::State& device) {
  if (device.transport == nullptr) return {{"name", nullptr}, {"absent", device.absent_why}};
  const device::TransportCounters counters = device.transport->counters();
  const device::TransportInfo& info = device.transport->info();
  const device::TransportState state = device.transport->state();
  return {{"name", info.name},
          {"serial", info.serial},
          {"simulation", info.simulation},
          {"state", wire::StateName(static_cast<wire::State>(state.state))},
          {"faults", FaultNames(state.faults)},
          {"waits_for_person", state.waits_for_person},
          {"received", counters.received},
          {"missed", counters.missed},
          {"superseded", counters.superseded},
          {"bad_frames", counters.bad_frames},
          {"bad_crc", counters.bad_crc},
          {"interrupted", counters.interrupted},
          {"sent", counters.sent},
          {"send_failed", counters.send_failed}};
}

json TextOrNull(const std::string& text) { return text.empty() ? json() : json(text); }

// Null: the base uses its nominal geometry.
json Calibration(const config::CalibrationChoice& choice) {
  if (!choice.file) return nullptr;
  return {{"file", choice.path},           {"date", choice.file->date},
          {"serial", choice.file->serial}, {"note", TextOrNull(choice.note)},
          {"shipped", choice.shipped},     {"expected_error_mm", choice.file->quality.expected_error_mm}};
}

json Room(const std::vector<room::RoomFinding>& findings) {
  json rows = json::array();
  for (const room::RoomFinding& finding : findings) {
    rows.push_back(
        {{"kind", finding.kind}, {"sensors", finding.sensors}, {"what", finding.what}, {"fix", finding.fix}});
  }
  return rows;
}

json ThreadRows() {
  json rows = json::array();
  for (const base::ListedThread& thread : base::RealtimeThreads()) {
    rows.push_back({{"name", thread.name}, {"id", thread.id}, {"realtime", thread.realtime}});
  }
  return rows;
}

json Ticks(const loop::TickThread& loop) {
  const loop::TickStatistics& s = loop.statistics();
  const loop::RealtimeStatus& realtime = loop.realtime();
  return {{"count", s.ticks.load()},
          {"late", s.late.load()},
          {"timeouts", s.timeouts.load()},
          {"us_median", s.tick_time.Quantile_us(0.5)},
          {"us_p99", s.tick_time.Quantile_us(0.99)},
          {"us_max", s.tick_time.max_us()},
          {"latency_us_median", s.latency.Quantile_us(0.5)},
          {"latency_us_p99", s.latency.Quantile_us(0.99)},
          {"response_us", 1e-3 * static_cast<double>(s.response_ns.load())},
          {"realtime", realtime.fifo && realtime.memory_locked},
          {"realtime_reason", realtime.reason},
          {"realtime_threads", ThreadRows()}};
}

// Null: the scene has no car.
json Race(const loop::VehicleStatistics& car) {
  if (!car.on.load()) return nullptr;
  return {{"laps", car.laps.load()},
          {"hits", car.hits.load()},
          {"speed_m_s", car.speed_m_s.load()},
          {"sliding", car.sliding.load()},
          {"lap_s", car.lap_s.load()},
          {"last_lap_s", car.last_lap_s.load()},
          {"best_lap_s", car.best_lap_s.load()}};
}

// Null: the scene has none.
json SoftBodies(const SoftProgress& soft) {
  if (soft.objects == 0) return nullptr;
  return {{"objects", soft.objects}, {"ready", soft.ready}, {"failed", soft.failed}, {"done", soft.done}};
}

// Null: there is no scene, or an application has handed it over as a document.
json SceneLoad(const Client* loader, const ClientScenes& scenes) {
  if (loader == nullptr || loader->app == nullptr) return nullptr;
  const scene::LoadOptions load = scenes.LoadOptionsFor(*loader->app);
  const base::Vec3& offset = load.offset_base_m;
  return {{"touch_untagged", load.touch_untagged},
          {"up", load.z_up ? "z" : "y"},
          {"fit", load.fit},
          {"tags", load.tags_by_name},
          {"scale", load.scale},
          {"offset_base_m", {offset.x, offset.y, offset.z}}};
}

std::uint32_t SculptedOf(const BuiltScene* built) {
  return built == nullptr || built->scene->live() == nullptr ? 0 : built->scene->live()->sculpt_session_count();
}

// What became of the strokes of earlier sessions, for people.
json NotesOf(const BuiltScene* built) {
  json notes = json::array();
  if (built == nullptr) return notes;
  for (const scene::JournalNote& note : built->notes) notes.push_back(note.text);
  return notes;
}

// The one that the tick should have.
json Scene(const StatusInput& input) {
  const BuiltScene* felt = input.scenes.felt();
  const std::uint64_t loader = felt == nullptr ? 0 : felt->client;  // a document's job is no client
  return {{"name", felt == nullptr ? "" : felt->file},
          {"generation", input.scenes.generation()},
          {"load", SceneLoad(input.clients.Find(loader), input.scenes)},
          {"triangles", felt == nullptr ? 0 : TrianglesOf(*felt->scene)},
          {"soft_bodies", SoftBodies(input.scenes.ProgressOf(felt))},
          {"sculpted", SculptedOf(felt)},
          {"strokes", NotesOf(felt)}};
}

// What scenes take of their limits, and which are being built or wait.
json Builds(const BuilderStatus& builds) {
  constexpr double kPerMB = 1e-6;
  json rows = json::array();
  for (const BuilderStatus::Row& row : builds.rows) {
    rows.push_back({{"client", row.client},
                    {"file", row.file},
                    {"soft_body", row.soft},
                    {"state", row.state},
                    {"needs_MB", kPerMB * static_cast<double>(row.need.peak_bytes)}});
  }
  return {{"kept_MB", kPerMB * static_cast<double>(builds.kept_bytes)},
          {"kept_limit_MB", kPerMB * static_cast<double>(builds.limits.kept_bytes)},
          {"client_limit_MB", kPerMB * static_cast<double>(builds.limits.client_bytes)},
          {"building_MB", kPerMB * static_cast<double>(builds.peak_bytes)},
          {"building_limit_MB", kPerMB * static_cast<double>(builds.limits.pool_bytes)},
          {"builders_limit", builds.limits.builders},
          {"builders", std::move(rows)}};
}

json SourceNames(base::SourceMask mask, const std::string& sign, const std::vector<std::uint16_t>& slots) {
  json names = json::array();
  for (; mask != 0; mask &= mask - 1) {
    names.push_back(sign + config::SourceText(static_cast<base::InputSource>(__builtin_ctzll(mask)), slots));
  }
  return names;
}

json KeyDevices(const KeyThread* keys) {
  json rows = json::array();
  if (keys == nullptr) return rows;
  for (const KeyThread::DeviceStatus& device : keys->Status()) {
    rows.push_back({{"rule", device.rule}, {"paths", device.paths}, {"problem", device.problem}});
  }
  return rows;
}

// Which sources feed each component now; and the state of these sources and of gestures.
json Inputs(const StatusInput& input, const loop::TickThread* loop, json key_devices) {
  json mapping = json::object();
  json sources = json::array();
  for (int i = 0; i < base::kInputComponentCount; ++i) {
    const auto component = static_cast<base::InputComponent>(i);
    const base::ComponentSources& feeds = input.mapping.at(component);
    json names = SourceNames(feeds.plus, "", input.key_slots);
    for (json& name : SourceNames(feeds.minus, "-", input.key_slots)) names.push_back(std::move(name));
    mapping[config::ComponentText(component)] = std::move(names);
  }
  if (loop != nullptr) {
    const loop::SourceStatistics& state = loop->statistics().sources;
    const base::SourceMask on = state.on.load(std::memory_order_relaxed);
    const base::SourceMask gestures = SourceBit(base::InputSource::kThumbstickX) - SourceBit(base::InputSource::kPress);
    for (base::SourceMask mask = input.mapping.used() | gestures; mask != 0; mask &= mask - 1) {
      const auto index = static_cast<std::size_t>(__builtin_ctzll(mask));
      sources.push_back({{"name", config::SourceText(static_cast<base::InputSource>(index), input.key_slots)},
                         {"on", ((on >> index) & 1) != 0},
                         {"times", state.times[index].load(std::memory_order_relaxed)}});
    }
  }
  return {{"mapping", mapping}, {"sources", sources}, {"devices", std::move(key_devices)}};
}

json ClientRows(const StatusInput& input) {
  json rows = json::array();
  for (const auto& [id, client] : input.clients.all()) {
    const std::shared_ptr<const BuiltScene> scene = input.scenes.Of(id);
    const protocol::BasePoseRequest* request = input.base_poses.RequestOf(id);  // null: no headset reported
    rows.push_back({{"id", id},
                    {"pid", client.info.pid},
                    {"application", client.info.application},
                    {"monitor", !client.is_application()},
                    {"session", SessionName(client.session)},
                    {"owner", id == input.clients.owner_id()},
                    {"scene", scene == nullptr ? "" : scene->file},
                    {"soft_bodies", SoftBodies(input.scenes.ProgressOf(id))},
                    {"sculpted", SculptedOf(scene.get())},
                    {"scene_MB", 1e-6 * static_cast<double>(input.scenes.KeptBytesOf(id))},
                    {"aligned", input.base_poses.IsAligned(id)},
                    {"runtime", request == nullptr ? "" : request->headset.runtime},
                    {"system", request == nullptr ? "" : request->headset.system}});
  }
  return rows;
}

double MovedSinceMeasured_m(const config::AlignmentEntry& entry) {
  return base::Distance(entry.position_space_m, entry.measured_position_space_m);
}

json Alignments(const config::AlignmentFile& file) {
  json rows = json::array();
  for (const config::AlignmentEntry& entry : file.entries) {
    const base::Quat& q = entry.orientation_space;
    const base::Vec3& p = entry.position_space_m;
    rows.push_back({{"runtime", entry.runtime},
                    {"system", entry.system},
                    {"space", entry.space},
                    {"method", entry.method},
                    {"date", entry.date},
                    {"samples", entry.samples},
                    {"rms_mm", entry.rms_mm},
                    {"expected_error_mm", entry.expected_error_mm},
                    {"rotation_deg", entry.rotation_deg},
                    {"recentred", entry.recentred},
                    {"doubtful", entry.doubtful},
                    {"base_moved", entry.base_moved},
                    {"drifted", entry.IsDrifted()},
                    {"starts", entry.drift.starts},
                    {"error_now_mm", entry.ErrorNow_mm()},
                    {"moved_m", MovedSinceMeasured_m(entry)},
                    {"position_space_m", {p.x, p.y, p.z}},
                    {"orientation_space_wxyz", {q.w, q.x, q.y, q.z}}});
  }
  return {{"placement", config::PolicyName(file.uncalibrated)}, {"stored", rows}};
}

// Null: forces are not stopped, and no latch is being removed.
json Stop(const EmergencyStop::State& stop) {
  using Latch = EmergencyStop::Latch;
  if (!stop.on && stop.latch == Latch::kNone) return nullptr;
  constexpr const char* kNames[] = {"none", "pending", "kept", "failed"};
  return {{"on", stop.on},
          {"by", stop.by},
          {"at", stop.at},
          {"from_before", stop.from_before},
          {"latch", kNames[static_cast<std::size_t>(stop.latch)]},
          {"file", TextOrNull(stop.file)},
          {"problem", TextOrNull(stop.problem)}};
}

}  // namespace

std::string WriteStatus(const StatusInput& input) {
  const EmergencyStop::State& stop = input.stop.state();
  json status = {
      {"service",
       {{"version", input.version}, {"pid", getpid()}, {"uptime_s", input.uptime_s}, {"instance", input.instance}}},
      {"stopped", stop.on ? json(stop.by) : json()},
      {"stop", Stop(stop)},
      {"clients", ClientRows(input)},
      {"scene", Scene(input)},
      {"builds", Builds(input.scenes.BuilderNow())},
      {"aligned", input.aligned},
      {"alignments", Alignments(input.base_poses.file())}};
  std::vector<std::string> problems = input.problems;
  const auto report = [&problems](const std::string& what, const std::string& problem) {
    if (!problem.empty()) problems.push_back(what + problem);
  };
  report("", input.stop.Problem());
  report("alignment: ", input.base_poses.problem());
  for (const auto& [id, client] : input.clients.all()) {
    const std::shared_ptr<const BuiltScene> scene = input.scenes.Of(id);
    if (scene == nullptr) continue;
    for (const auto& journal : scene->journals) report("sculpting: ", journal->state().problem);
  }
  if (input.followed_base.headset() && !input.followed_base.seen()) {
    report("base: ", "no program reports where it is carried; run `omni follow`, or `omni follow --off` if it stands");
  }
  json key_devices = KeyDevices(input.keys);  // not with the device locked
  input.device.With([&](const AttachedDevice::State& device) {
    report("calibration: ", device.calibration.problem);
    report("calibration: ", device.misfit);
    report("host: ", device.starved);
    for (const room::RoomFinding& finding : device.room) report("room: ", RoomText(finding));
    status["device"] = Device(device);
    status["calibration"] = Calibration(device.calibration);
    status["calibration_refused"] = TextOrNull(device.calibration.problem);
    status["calibration_misfit"] = TextOrNull(device.misfit);
    status["room"] = Room(device.room);
    status["inputs"] = Inputs(input, device.loop, std::move(key_devices));
    if (device.loop != nullptr) status["tick"] = Ticks(*device.loop);
    status["race"] = device.loop == nullptr ? json() : Race(device.loop->statistics().vehicle);
    // In capitals, which come first in the sorted text that people read.
    if (device.transport != nullptr && device.transport->info().simulation) status["SIMULATION"] = kSimulationText;
  });
  status["problems"] = std::move(problems);
  // Names come from other programs: invalid UTF-8 is replaced, never thrown on.
  return status.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace omni::daemon
