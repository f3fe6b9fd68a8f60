// Documents that are meant to cost as much as they can: each is loaded or refused at a cost that grows as the file
// does.
#include <gtest/gtest.h>

#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>

#include "service/haptics/scene/scene.h"
#include "service/scene/load_scene.h"
#include "tests/scene/files.h"
#include "tests/scene/stream_bombs.h"
#include "tests/support/bombs.h"
#include "tests/support/process/measured_child.h"

namespace omni::scene::test {
namespace test_scene_bombs {

using omni::test::Bomb;
using omni::test::kSceneBombs;
using omni::test::RunInChild;

// A document in memory, as applications give it.
class Document {
 public:
  explicit Document(const std::string& bytes) : descriptor_(memfd_create("bomb", MFD_CLOEXEC)) {
    for (std::size_t done = 0; done < bytes.size();) {
      const ssize_t more = write(descriptor_, bytes.data() + done, bytes.size() - done);
      if (more <= 0) std::abort();
      done += static_cast<std::size_t>(more);
    }
  }
  ~Document() { close(descriptor_); }
  Document(const Document&) = delete;
  Document& operator=(const Document&) = delete;

  base::Result<haptics::Scene> Load() const {
    LoadOptions options = kTouchAll;
    options.memory = descriptor_;
    LoadReport load;
    haptics::BuildReport build;
    return LoadScene("bomb.gltf", options, nullptr, load, build);
  }
  // Of this thread: what others do on the machine does not count.
  double Cpu_s() const {
    const auto now_s = [] {
      timespec t{};
      clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
      return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
    };
    const double start_s = now_s();
    (void)Load();
    return now_s() - start_s;
  }

 private:
  int descriptor_;
};

// Eight times the bytes cost about eight times as much: 64 times, where it grows as their square. Measured again where
// it seems to cost more, and the least counts.
void ExpectCostGrowsAsSize(const char* name, const Document& one, const Document& eight) {
  double one_s = one.Cpu_s(), eight_s = eight.Cpu_s();
  for (int i = 0; i < 8 && (i < 1 || eight_s > 20 * one_s + 1e-3); ++i) {
    one_s = std::min(one_s, one.Cpu_s());
    eight_s = std::min(eight_s, eight.Cpu_s());
  }
  EXPECT_LT(eight_s, 20 * one_s + 1e-3) << name << ": " << one_s << " s, then " << eight_s << " s";
}

TEST(SceneBombs, TimeGrowsLinearlyWithFileSize) {
  constexpr std::size_t kBytes = 50'000;
  for (const Bomb& bomb : kSceneBombs)
    ExpectCostGrowsAsSize(bomb.name, Document(bomb.make(kBytes)), Document(bomb.make(8 * kBytes)));
  for (const Bomb& bomb : kStreamBombs)
    ExpectCostGrowsAsSize(bomb.name, Document(bomb.make(kBytes / 2)), Document(bomb.make(4 * kBytes)));
}

// The largest share have nodes of a few bytes, which become objects with names, tags and lines of explanation.
TEST(SceneBombs, MemoryIsBoundedByTheFile) {
  if (!omni::test::kMemoryCounts) GTEST_SKIP() << "the sanitizer takes memory of its own";
  constexpr std::size_t kBytes = 3'000'000;
  for (const Bomb& bomb : kSceneBombs) {
    const std::string text = bomb.make(kBytes);
    const auto outcome = RunInChild(0, [&] {
      (void)Document(text).Load();
      return 0;
    });
    EXPECT_EQ(outcome.status, 0) << bomb.name;
    EXPECT_LT(outcome.memory_MB, 40e-6 * static_cast<double>(text.size()) + 16) << bomb.name;
  }
}

// A byte holds up to 16 vertices, which take 90 bytes each; and 64 MiB may be decoded from any file.
TEST(SceneBombs, MemoryOfCompressedStreamsIsBoundedByWhatTheyHold) {
  if (!omni::test::kMemoryCounts) GTEST_SKIP() << "the sanitizer takes memory of its own";
  for (const Bomb& bomb : kStreamBombs) {
    const Document document(bomb.make(200'000));
    const auto outcome = RunInChild(0, [&] {
      (void)document.Load();
      return 0;
    });
    EXPECT_EQ(outcome.status, 0) << bomb.name;
    EXPECT_LT(outcome.memory_MB, 16 * 90 * 0.2 + 150) << bomb.name;
  }
}

// 48 MB of texts, and all the others, where there is memory for some of it only.
TEST(SceneBombs, OutOfMemoryIsAnErrorNotACrash) {
  if (!omni::test::kMemoryCounts) GTEST_SKIP() << "the sanitizer takes memory of its own";
  const Document texts(kSceneBombs[2].make(48'000'000));
  EXPECT_EQ(RunInChild(800, [&] { return texts.Load().ok() ? 1 : 0; }).status, 0);
  for (const Bomb& bomb : kSceneBombs) {
    const Document document(bomb.make(400'000));
    for (const std::size_t space_MB : {1, 2, 3, 5, 8, 12, 20}) {
      const auto outcome = RunInChild(space_MB, [&] {
        (void)document.Load();
        return 0;
      });
      EXPECT_EQ(outcome.status, 0) << bomb.name << " in " << space_MB << " MB";
    }
  }
  for (const Bomb& bomb : kStreamBombs) {
    const Document document(bomb.make(50'000));
    for (const std::size_t space_MB : {1, 3, 8, 20, 60}) {
      const auto outcome = RunInChild(space_MB, [&] {
        (void)document.Load();
        return 0;
      });
      EXPECT_EQ(outcome.status, 0) << bomb.name << " in " << space_MB << " MB";
    }
  }
}

TEST(SceneBombs, LoadingNodesTakesLinearTime) {
  const Document all(omni::test::bombs::HonestNodes(100'000));
  const base::Result<haptics::Scene> scene = all.Load();
  ASSERT_TRUE(scene.ok()) << scene.error();
  ExpectCostGrowsAsSize("honest nodes", Document(omni::test::bombs::HonestNodes(12'500)), all);
}

}  // namespace test_scene_bombs
}  // namespace omni::scene::test
