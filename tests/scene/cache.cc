// The disk cache: returns what was put, or nothing.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>

#include "service/haptics/scene/check_scene.h"
#include "service/haptics/scene/scene.h"
#include "service/scene/cache/cache_store.h"
#include "service/scene/cache/cached_scene.h"
#include "service/scene/load_scene.h"
#include "tests/scene/files.h"

namespace omni::scene::test {
namespace test_scene_cache {

namespace fs = std::filesystem;

CacheKey Key(std::uint8_t number) {
  CacheKey key{"scene", {}};
  key.digest[0] = number;
  return key;
}

CacheBlock BlockOf(std::size_t bytes, std::uint8_t seed) {
  CacheBlock block(bytes);
  for (std::size_t i = 0; i < bytes; ++i) block[i] = static_cast<std::byte>(i * 7 + seed);
  return block;
}

std::string OnlyFile(const std::string& folder) {
  std::string found;
  for (const auto& entry : fs::directory_iterator(folder)) found = entry.path().string();
  return found;
}

std::span<const std::byte> AsBytes(const std::string& text) { return std::as_bytes(std::span(text)); }

TEST(SceneCache, DigestMatchesFips180Vectors) {  // vectors of FIPS 180-4's examples
  EXPECT_EQ(ToHex(Sha256().Finish()), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  Sha256 abc;
  abc.Add(AsBytes("abc"));
  EXPECT_EQ(ToHex(abc.Finish()), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  Sha256 two;
  two.Add(AsBytes("abcdbcdecdefdefgefghfghighij"));
  two.Add(AsBytes("hijkijkljklmklmnlmnomnopnopq"));
  EXPECT_EQ(ToHex(two.Finish()), "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  Sha256 million;
  for (int i = 0; i < 1000; ++i) million.Add(AsBytes(std::string(1000, 'a')));
  EXPECT_EQ(ToHex(million.Finish()), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(SceneCache, ReturnsStoredBlocks) {
  const TempFolder folder;
  CacheStore store(folder.Path("a/omni"));
  ASSERT_EQ(store.problem(), "");
  struct stat status {};
  ASSERT_EQ(stat(store.folder().c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0700U);
  std::string damage;
  EXPECT_FALSE(store.Get(Key(1), damage));
  EXPECT_EQ(damage, "");
  for (const std::size_t bytes : {0U, 1U, 7U, 8U, 100'001U}) {
    ASSERT_TRUE(store.Put(Key(1), BlockOf(bytes, 3)));
    const auto got = store.Get(Key(1), damage);
    ASSERT_TRUE(got) << damage;
    EXPECT_EQ(*got, BlockOf(bytes, 3));
    EXPECT_FALSE(store.Get(Key(2), damage));
  }
  EXPECT_EQ(store.Usage().files, 1U) << "no unfinished file stays";
  EXPECT_EQ(CacheStore(store.folder()).Clear().files, 1U);
  EXPECT_FALSE(store.Get(Key(1), damage));
}

TEST(SceneCache, DetectsAnyChangedByteOrLength) {
  const TempFolder folder;
  CacheStore store(folder.Path("omni"));
  std::string damage;
  ASSERT_TRUE(store.Put(Key(1), BlockOf(40, 5)));
  const std::string file = OnlyFile(store.folder());
  const std::string whole = ReadAll(file);
  ASSERT_EQ(whole.size(), 64U + 40U);
  const auto write = [&](const std::string& bytes) { std::ofstream(file, std::ios::binary) << bytes; };
  for (std::size_t i = 0; i < whole.size(); ++i) {
    if (i >= 24 && i < 32) continue;  // the kind is in the name as well
    std::string bytes = whole;
    bytes[i] = static_cast<char>(bytes[i] ^ 0x10);
    write(bytes);
    EXPECT_FALSE(store.Get(Key(1), damage)) << i;
    EXPECT_NE(damage, "") << i;
    EXPECT_FALSE(fs::exists(file)) << "what is damaged is removed";
  }
  for (std::size_t length = 0; length < whole.size(); ++length) {
    write(whole.substr(0, length));
    EXPECT_FALSE(store.Get(Key(1), damage)) << length;
  }
  write(whole + "x");
  EXPECT_FALSE(store.Get(Key(1), damage));
  write(whole);
  EXPECT_TRUE(store.Get(Key(1), damage)) << damage;
}

TEST(SceneCache, EvictsLeastRecentlyUsedFirst) {
  const TempFolder folder;
  CacheStore store(folder.Path("omni"), 3500);
  std::string damage;
  for (std::uint8_t k = 1; k <= 3; ++k) {
    ASSERT_TRUE(store.Put(Key(k), BlockOf(1000, k)));
    usleep(20'000);  // file times
  }
  ASSERT_TRUE(store.Get(Key(1), damage));  // used: 2 is now the oldest
  usleep(20'000);
  ASSERT_TRUE(store.Put(Key(4), BlockOf(1000, 4)));
  EXPECT_TRUE(store.Get(Key(1), damage));
  EXPECT_FALSE(store.Get(Key(2), damage));
  EXPECT_TRUE(store.Get(Key(3), damage));
  EXPECT_TRUE(store.Get(Key(4), damage));
  EXPECT_LE(store.Usage().bytes, 3500U);
  EXPECT_FALSE(store.Put(Key(5), BlockOf(4000, 5))) << "larger than the store";
  EXPECT_TRUE(store.Get(Key(4), damage));
}

TEST(SceneCache, UnusableFolderDisablesTheCache) {
  const TempFolder folder;
  std::string damage;
  const std::string file = folder.Write("file", "x");
  const std::string open = folder.Path("open");
  fs::create_directory(open);
  chmod(open.c_str(), 0777);
  fs::create_directory_symlink(open, folder.Path("link"));
  for (const std::string& bad :
       {file, file + "/below", open, folder.Path("link"), std::string(), std::string("/proc/omni")}) {
    CacheStore store(bad);
    EXPECT_NE(store.problem(), "") << bad;
    EXPECT_FALSE(store.Put(Key(1), BlockOf(10, 1)));
    EXPECT_FALSE(store.Get(Key(1), damage));
    EXPECT_EQ(store.Clear().files, 0U);
  }
}

TEST(SceneCache, TwoProcessesShareTheCache) {
  const TempFolder folder;
  const std::string place = folder.Path("omni");
  const auto work = [&](std::uint8_t self) {
    CacheStore store(place, 200'000);
    std::string damage;
    for (int i = 0; i < 100; ++i) {
      const auto k = static_cast<std::uint8_t>(i % 5);
      if (!store.Put(Key(k), BlockOf(30'000, k))) return false;
      const auto got = store.Get(Key(static_cast<std::uint8_t>((i + self) % 5)), damage);
      if (!damage.empty()) return false;
      if (got && *got != BlockOf(30'000, static_cast<std::uint8_t>((i + self) % 5))) return false;
    }
    return true;
  };
  const pid_t child = fork();
  if (child == 0) _exit(work(1) ? 0 : 1);
  EXPECT_TRUE(work(2));
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
}

// A closed sphere of `n` rings, 20 mm around (0, 0.05, 0) of the file, large enough to be cached.
Model Ball(int n) {
  std::vector<float> positions;
  std::vector<std::uint32_t> indices;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j < n; ++j) {
      const double u = std::acos(-1.0) * i / n, v = 2 * std::acos(-1.0) * j / n;
      for (const double c :
           {0.02 * std::sin(u) * std::cos(v), 0.05 + 0.02 * std::cos(u), 0.02 * std::sin(u) * std::sin(v)})
        positions.push_back(static_cast<float>(c));
      if (i == n) continue;
      const auto at = [n](int a, int b) { return static_cast<std::uint32_t>(a * n + b % n); };
      indices.insert(indices.end(),
                     {at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
    }
  }
  Model model = Tetra();
  model.bin = Bytes(positions) + Bytes(indices);
  model.json["accessors"][0]["count"] = positions.size() / 3;
  model.json["accessors"][1]["count"] = indices.size();
  model.json["accessors"][1]["componentType"] = 5125;
  model.json["bufferViews"][0]["byteLength"] = 4 * positions.size();
  model.json["bufferViews"][1] = {
      {"buffer", 0}, {"byteOffset", 4 * positions.size()}, {"byteLength", 4 * indices.size()}};
  model.json["buffers"][0]["byteLength"] = model.bin.size();
  model.json["nodes"][0]["extras"]["haptic"]["stiffness"] = 500;
  model.json["nodes"][0]["extras"]["haptic"]["wobble"] = 1;  // a warning
  return model;
}

struct LoadedByCache {
  haptics::Scene scene;
  LoadReport load;
  haptics::BuildReport build;
};

LoadedByCache LoadBy(CacheStore& cache, const std::string& file, const LoadOptions& options = {}) {
  LoadedByCache loaded;
  base::Result<haptics::Scene> scene = LoadScene(file, options, &cache, loaded.load, loaded.build);
  EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error());
  if (scene.ok()) loaded.scene = std::move(*scene);
  return loaded;
}

bool Same(const haptics::Scene& a, const haptics::Scene& b) {
  return std::equal(a.block().begin(), a.block().end(), b.block().begin(), b.block().end());
}

TEST(SceneCache, CachedSceneAndReportsMatchTheBuiltOnes) {
  const TempFolder folder;
  CacheStore cache(folder.Path("omni"));
  Model model = Ball(60);
  const std::string file = folder.Write("ball.glb", model.Bytes());
  const LoadedByCache built = LoadBy(cache, file);
  EXPECT_FALSE(built.load.cached);
  EXPECT_EQ(built.load.cache, "not in the cache, kept");
  const LoadedByCache cached = LoadBy(cache, file);
  EXPECT_TRUE(cached.load.cached) << cached.load.cache;
  EXPECT_TRUE(Same(built.scene, cached.scene));
  EXPECT_EQ(built.load.warnings, cached.load.warnings);
  ASSERT_EQ(cached.load.warnings.size(), 1U);
  EXPECT_EQ(built.build.lines, cached.build.lines);
  EXPECT_EQ(built.load.rows.size(), cached.load.rows.size());
  EXPECT_EQ(built.load.bytes_read, cached.load.bytes_read);
  // Anything that it depends on: another scene.
  EXPECT_FALSE(LoadBy(cache, file, {.scale = 1.01}).load.cached);
  model.bin[5] = static_cast<char>(model.bin[5] ^ 1);
  EXPECT_FALSE(LoadBy(cache, folder.Write("ball.glb", model.Bytes())).load.cached);
  model.json["nodes"][0]["extras"]["haptic"]["stiffness"] = 501;
  EXPECT_FALSE(LoadBy(cache, folder.Write("ball.glb", model.Bytes())).load.cached);
}

TEST(SceneCache, SmallScenesAreNotCached) {
  const TempFolder folder;
  CacheStore cache(folder.Path("omni"));
  const LoadedByCache loaded = LoadBy(cache, folder.Write("small.glb", Tetra().Bytes()), kTouchAll);
  EXPECT_NE(loaded.load.cache.find("below 5000"), std::string::npos) << loaded.load.cache;
  EXPECT_EQ(cache.Usage().files, 0U);
}

TEST(SceneCache, DamagedEntryIsRebuiltAndReported) {
  const TempFolder folder;
  CacheStore cache(folder.Path("omni"));
  const std::string file = folder.Write("ball.glb", Ball(60).Bytes());
  const LoadedByCache built = LoadBy(cache, file);
  const std::string entry = OnlyFile(cache.folder());
  std::string bytes = ReadAll(entry);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
  std::ofstream(entry, std::ios::binary) << bytes;
  const LoadedByCache again = LoadBy(cache, file);
  EXPECT_FALSE(again.load.cached);
  EXPECT_EQ(again.load.cache, "the cached file has a wrong checksum: rebuilt, kept");
  EXPECT_TRUE(Same(built.scene, again.scene));
  EXPECT_TRUE(LoadBy(cache, file).load.cached);
}

TEST(SceneCache, UntaggedFileIsSkippedUnlessRequested) {
  const TempFolder folder;
  CacheStore cache(folder.Path("omni"));
  Model model = Tetra();
  model.bin += std::string(1'000'000, 'x');
  model.json["buffers"][0]["byteLength"] = model.bin.size();
  const std::string file = folder.Write("plain.glb", model.Bytes());
  const LoadedByCache loaded = LoadBy(cache, file);
  EXPECT_TRUE(loaded.scene.empty());
  EXPECT_TRUE(loaded.load.skipped);
  EXPECT_LT(loaded.load.bytes_read, 2000U);
  EXPECT_EQ(loaded.load.images_decoded, 0U);
  ASSERT_FALSE(loaded.load.rows.empty());
  EXPECT_NE(loaded.load.rows[0].why.find("no haptic tag"), std::string::npos);
  Loaded input = Load(file, {});
  ASSERT_TRUE(input.result.ok());
  EXPECT_TRUE(input.scene().objects.empty());
  EXPECT_FALSE(LoadBy(cache, file, {.touch_untagged = true}).scene.empty());
}

}  // namespace test_scene_cache
}  // namespace omni::scene::test
