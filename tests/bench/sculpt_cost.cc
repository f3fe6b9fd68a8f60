// Times strokes, undo and the tick's part of sculpting; run by `omni-bench sculpt`. Prints a JSON array of rows; rows
// with a key "table" belong to side tables.
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <thread>

#include <nlohmann/json.hpp>

#include "service/haptics/sculpt/mesh/check_manifold.h"
#include "service/haptics/sculpt/sculpt_query.h"
#include "service/scene/journal/sculpt_journal.h"
#include "service/tools/common/row_table.h"
#include "tests/bench/arguments.h"
#include "tests/bench/printed_rows.h"
#include "tests/support/touch/sculpt_hand.h"

namespace omni::haptics::sculpt {
namespace {

using nlohmann::ordered_json;

constexpr double kBodyRadius_m = 0.03;

double Now_us() {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

long Switches() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_nivcsw;
}

using tools::Mean;
using tools::Quantile;

struct Options {
  std::uint64_t seed = 1;
  bool quick = false;
};

Vec3 OnBall(Random& random) {
  Vec3 p = random.InBox(1);
  while (!(SquaredNorm(p) > 0.01 && SquaredNorm(p) < 1)) p = random.InBox(1);
  return kBodyRadius_m * Normalized(p);
}

// A publish during which the kernel took the thread off its core is left out; edits are longer than a time slice on a
// busy machine, and all count.
struct Samples {
  std::vector<double> begin_us, move_us, publish_us, copy_us, triangles, pages;
};

// Work that Publish leaves to the edit: copying the pages it is going to write.
double CopyTime_us(const PagedMesh& mesh, std::uint32_t pages, std::vector<Page>& to) {
  if (to.size() < pages) to.resize(pages);
  const std::uint32_t stride = std::max(1U, mesh.page_count() / pages);
  const double begin_us = Now_us();
  for (std::uint32_t k = 0; k < pages; ++k) {
    std::memcpy(static_cast<void*>(&to[k]), &mesh.GetPage(k * stride % mesh.page_count()), sizeof(Page));
  }
  return Now_us() - begin_us;
}

void TakeSample(SculptEditor& editor, const Brush& brush, Random& random, std::vector<Page>& scratch,
                Samples& samples) {
  const SurfacePoint at = On(editor, OnBall(random));
  const double offset_m = random.Next() % 2 == 0 ? 2e-4 : -2e-4;
  const double t0_us = Now_us();
  if (!editor.Begin(at, brush).ok()) return;
  const double t1_us = Now_us();
  editor.MoveTo(offset_m);
  const double t2_us = Now_us();
  const long between = Switches();
  const double t3_us = Now_us();
  const PublishReport publish = editor.Publish();
  const double t4_us = Now_us();
  const bool quiet_publish = Switches() == between;
  editor.End();
  const double copy_us = CopyTime_us(editor.mesh(), publish.pages, scratch);
  editor.Undo();
  editor.Publish();
  editor.publisher().Acquire();
  samples.triangles.push_back(static_cast<double>(editor.report().triangles));
  samples.pages.push_back(publish.pages);
  samples.copy_us.push_back(copy_us);
  if (quiet_publish) samples.publish_us.push_back(t4_us - t3_us);
  samples.begin_us.push_back(t1_us - t0_us);
  samples.move_us.push_back(t2_us - t1_us);
}

void AddPublishRows(const Options& options, int squares, ordered_json& rows) {
  const auto editor = EditorOf(BumpyBall(squares, kBodyRadius_m));
  editor->publisher().SetReader(true);
  editor->publisher().Acquire();
  std::vector<Page> scratch;
  for (const double radius_m : {0.0025, 0.005, 0.01}) {
    Random random(options.seed);
    Brush brush;
    brush.radius_m = radius_m;
    const double wanted = 3e7 / (radius_m * radius_m * 1e6 * squares * squares);  // the larger, the fewer
    const int count = options.quick ? 20 : static_cast<int>(std::clamp(wanted, 200.0, 1500.0));
    Samples samples;
    for (int k = 0; k < count; ++k) TakeSample(*editor, brush, random, scratch, samples);
    std::vector<double> edit_us;
    for (std::size_t k = 0; k < samples.begin_us.size(); ++k) {
      edit_us.push_back(samples.begin_us[k] + samples.move_us[k]);
    }
    rows.push_back({{"triangles", editor->mesh().triangle_count()},
                    {"radius_mm", 1e3 * radius_m},
                    {"publish_us_median", Quantile(samples.publish_us, 0.5)},
                    {"publish_us_p99", Quantile(samples.publish_us, 0.99)},
                    {"page_copy_us_median", Quantile(samples.copy_us, 0.5)},
                    {"begin_us_median", Quantile(samples.begin_us, 0.5)},
                    {"move_us_median", Quantile(samples.move_us, 0.5)},
                    {"edit_us_median", Quantile(edit_us, 0.5)},
                    {"edit_us_p99", Quantile(edit_us, 0.99)},
                    {"edited_triangles", std::round(Mean(samples.triangles))},
                    {"edited_pages", std::round(Mean(samples.pages))},
                    {"pages", editor->mesh().page_count()},
                    {"n", samples.publish_us.size()}});
  }
}

// Cost in the tick: loading the newest generation, and queries; fifty at a time.
void AddTickRow(const Options& options, int squares, ordered_json& rows) {
  const auto editor = EditorOf(BumpyBall(squares, kBodyRadius_m));
  Random random(options.seed);
  std::vector<Vec3> places;
  for (int k = 0; k < 1000; ++k) places.push_back(random.Uniform(0.95, 1.05) * OnBall(random));
  const auto time = [&](auto&& ask) {
    std::vector<double> us;
    constexpr std::size_t kGroup = 50;
    for (std::size_t batch = 0; batch < (options.quick ? 40U : 2000U); ++batch) {
      const long switches = Switches();
      const double begin_us = Now_us();
      for (std::size_t k = 0; k < kGroup; ++k) ask(places[(batch * kGroup + k) % places.size()]);
      const double end_us = Now_us();
      if (Switches() == switches) us.push_back((end_us - begin_us) / kGroup);
    }
    return Quantile(us, 0.5);
  };
  double sink = 0;
  SculptPublisher& publisher = editor->publisher();
  const double acquire_us = time([&](const Vec3&) { sink += static_cast<double>(publisher.Acquire()->generation); });
  const SculptSurface surface(*publisher.Acquire());
  const double nearest_us = time([&](const Vec3& p) { sink += NearestInTree(surface, 0, p).closest.distance_squared; });
  const double crossing_us =
      time([&](const Vec3& p) { sink += CrossingInTree(surface, 0, p, (1 - 1e-3) * p, false).t; });
  const double rebind_us = time([&](const Vec3& p) {
    KeptFeature feature{0, {}, p, p};
    sink += RebindFeature(surface, 0.01, feature);
  });
  rows.push_back({{"table", "tick"},
                  {"triangles", editor->mesh().triangle_count()},
                  {"acquire_us", acquire_us},
                  {"nearest_us", nearest_us},
                  {"crossing_us", crossing_us},
                  {"rebind_us", rebind_us},
                  {"finite", std::isfinite(sink)}});
}

// Many strokes, then all of them undone.
void AddUndoRow(const Options& options, const char* body, const InputObject& object, int strokes, double size_m,
                ordered_json& rows) {
  const double begin_us = Now_us();
  const auto editor = EditorOf(object);
  Random random(options.seed + 1);
  const std::uint64_t before = editor->mesh().Hash();
  const std::uint32_t triangles = editor->mesh().triangle_count();
  int checks = 0, failures = 0, refused = 0;
  double least_area_m2 = 1, least_shape = 1;
  for (int k = 0; k < strokes; ++k) {
    Brush brush;
    brush.radius_m = random.Uniform(0.1, 0.2) * size_m;
    brush.falloff = static_cast<Falloff>(random.Next() % 3);
    brush.symmetry.enabled = random.Next() % 8 == 0;
    const double offset_m = random.Uniform(-0.04, 0.04) * size_m;
    refused += !editor->Stroke(On(*editor, 1.5 * random.InBox(size_m)), brush, offset_m).ok();
    editor->Publish();
    if (k % 100 != 99) continue;
    const ManifoldReport report = CheckManifold(editor->mesh());
    ++checks;
    failures += !report.ok();
    least_area_m2 = std::min(least_area_m2, report.least_area_m2);
    least_shape = std::min(least_shape, report.least_shape);
  }
  const std::uint32_t sculpted = editor->mesh().triangle_count();
  const std::uint64_t after = editor->mesh().Hash();
  const double undo_MB = 1e-6 * static_cast<double>(editor->undo_bytes());
  const std::size_t steps = editor->undo_steps();
  while (editor->Undo()) {
  }
  const bool undone = editor->mesh().Hash() == before && CheckManifold(editor->mesh()).ok();
  while (editor->Redo()) {
  }
  const bool redone = editor->mesh().Hash() == after;
  rows.push_back({{"table", "undo"},
                  {"body", body},
                  {"strokes", strokes},
                  {"refused", refused},
                  {"triangles_before", triangles},
                  {"triangles_after", sculpted},
                  {"manifold_checks", checks},
                  {"manifold_failures", failures},
                  {"least_area_um2", 1e12 * least_area_m2},
                  {"least_shape", least_shape},
                  {"undo_bit_identical", undone},
                  {"redo_bit_identical", redone},
                  {"undo_MB", undo_MB},
                  {"undo_kB_per_stroke", 1e3 * undo_MB / static_cast<double>(std::max<std::size_t>(steps, 1))},
                  {"page_MB", 1e-6 * static_cast<double>(editor->mesh().page_bytes())},
                  {"seconds", 1e-6 * (Now_us() - begin_us)}});
}

// Strokes of twenty moves, every second one with a journal that another thread writes and syncs: what the editor's
// thread has to do for it.
void AddJournalRow(const Options& options, int squares, ordered_json& rows) {
  const auto editor = EditorOf(BumpyBall(squares, kBodyRadius_m));
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("omni-journal-" + std::to_string(getpid()));
  UndoStep rest;
  for (std::uint32_t page = 0; page < editor->mesh().page_count(); ++page) {
    AppendRuns(page, EmptyPage().content, editor->mesh().GetPage(page).content, rest);
  }
  scene::SculptJournal journal(folder.string(), {.identity = editor->mesh().Hash(), .object = "ball"}, std::move(rest));
  std::atomic<bool> stop{false};
  std::thread writer([&] {
    while (!stop.load()) {
      journal.Flush();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  Random random(options.seed + 3);
  std::vector<double> without_us, with_us, end_without_us, end_with_us;
  for (int k = 0; k < (options.quick ? 40 : 600); ++k) {
    const bool kept = k % 2 == 1;
    editor->SetLog({});
    if (kept) {
      editor->SetLog([&](EditKind, const UndoStep& step) { journal.Append(scene::RecordKind::kStroke, step); });
    }
    Brush brush;
    const SurfacePoint at = On(*editor, OnBall(random));
    const double begin_us = Now_us();
    if (!editor->Begin(at, brush).ok()) continue;
    for (int move = 1; move <= 20; ++move) {
      editor->MoveTo(5e-5 * move);
      editor->Publish();
    }
    const double last_us = Now_us();
    editor->End();
    const double end_us = Now_us();
    (kept ? with_us : without_us).push_back(end_us - begin_us);
    (kept ? end_with_us : end_without_us).push_back(end_us - last_us);
    editor->publisher().Acquire();
  }
  stop = true;
  writer.join();
  const double kept_kB = 1e-3 * static_cast<double>(std::filesystem::file_size(journal.state().file));
  std::filesystem::remove_all(folder);
  rows.push_back({{"table", "journal"},
                  {"triangles", editor->mesh().triangle_count()},
                  {"stroke_us_median", Quantile(without_us, 0.5)},
                  {"stroke_us_median_kept", Quantile(with_us, 0.5)},
                  {"ratio", Quantile(with_us, 0.5) / Quantile(without_us, 0.5)},
                  {"end_us_median", Quantile(end_without_us, 0.5)},
                  {"end_us_median_kept", Quantile(end_with_us, 0.5)},
                  {"end_us_p99_kept", Quantile(end_with_us, 0.99)},
                  {"journal_kB_per_stroke", kept_kB / static_cast<double>(with_us.size())},
                  {"n", with_us.size()}});
}

// One grab after another by a pen that presses, pulls or pushes at some speed and releases; some are undone under the
// tip. Largest change of the requested force from tick to tick, before the limit of the device.
void AddForceRow(const Options& options, int squares, const char* what, double speed_m_s, double way_m, bool undo,
                 ordered_json& rows) {
  SculptHand hand(BumpyBall(squares, kBodyRadius_m), {}, Brush{});
  SculptEditor& editor = hand.editor();
  double largest_N = 0, moved_mm = 0;
  int grabs = 0, undone = 0;
  Random random(options.seed + 2);
  const std::uint64_t first = editor.publisher().generation();
  for (int k = 0; k < (options.quick ? 4 : 40); ++k) {
    const SurfacePoint at = On(editor, OnBall(random));
    const Vec3 out = Normalized(at.position);
    hand.MoveTo(at.position + 0.004 * out);  // from the last place: no hand's motion
    hand.Rest(200);
    hand.ForgetSteps();
    hand.Go(at.position - 0.0016 * out, 0.03);
    hand.Rest(230);
    grabs += hand.state().phase == SculptPhase::kHeld;
    hand.Go(at.position + way_m * out, speed_m_s);
    hand.Rest(360);
    moved_mm = std::max(moved_mm, 1e3 * std::abs(hand.state().offset_m));
    if (undo) {
      hand.Go(On(editor, hand.tip()).position - 0.001 * out, 0.03);
      undone += editor.Undo();
      hand.Rest(60);
    }
    largest_N = std::max(largest_N, hand.largest_step_N());
  }
  rows.push_back({{"table", "feel"},
                  {"what", what},
                  {"triangles", editor.mesh().triangle_count()},
                  {"speed_mm_s", 1e3 * speed_m_s},
                  {"grabs", grabs},
                  {"undone_under_tip", undone},
                  {"generations", editor.publisher().generation() - first},
                  {"moved_mm_max", moved_mm},
                  {"force_step_max_N_per_ms", largest_N},
                  {"slew_limit_N_per_ms", 0.85},
                  {"manifold", CheckManifold(editor.mesh()).ok()}});
}

ordered_json Run(const Options& options) {
  ordered_json rows = ordered_json::array();
  const std::vector<int> sizes = options.quick ? std::vector<int>{29, 91} : std::vector<int>{29, 91, 269};
  for (const int squares : sizes) AddPublishRows(options, squares, rows);
  for (const int squares : sizes) AddTickRow(options, squares, rows);
  for (const int squares : sizes) AddJournalRow(options, squares, rows);
  const int strokes = options.quick ? 100 : 10'000;
  AddUndoRow(options, "ball 10k", BumpyBall(29, kBodyRadius_m), strokes, kBodyRadius_m, rows);
  AddUndoRow(options, "block 12", Block(1, {0.02, 0.02, 0.01}), options.quick ? 100 : 1000, 0.02, rows);
  for (const int squares : {29, 91}) {
    AddForceRow(options, squares, "pull", 0.03, 0.006, false, rows);
    AddForceRow(options, squares, "push", 0.03, -0.006, false, rows);
    AddForceRow(options, squares, "pull fast", 0.1, 0.01, false, rows);
    AddForceRow(options, squares, "pull, undo under the tip", 0.03, 0.006, true, rows);
    AddForceRow(options, squares, "push, undo under the tip", 0.03, -0.006, true, rows);
  }
  return rows;
}

}  // namespace
}  // namespace omni::haptics::sculpt

int main(int argc, char** argv) {
  omni::haptics::sculpt::Options options;
  std::string seed = std::to_string(options.seed);
  const auto ended = omni::bench::ParseArguments(argc, argv, "omni_bench_sculpt",
                                                 {{"--quick", &options.quick}, {"--seed", nullptr, &seed}});
  if (ended) return *ended;
  options.seed = omni::bench::Number(seed);
  omni::bench::PrintRows(omni::haptics::sculpt::Run(options));
  return 0;
}
