// The layout of a surface memory: planned buffers fit and do not overlap; garbage is rejected.
#include "service/protocol/surfaces/surface_layout.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <random>

#include "service/protocol/text.h"

namespace omni::protocol {
namespace test_protocol_surface_layout {

SurfacePlan RandomPlan(std::mt19937_64& random, std::uint32_t object, std::uint32_t most) {
  SurfacePlan plan{.name = "object " + std::to_string(object), .object = object};
  plan.flags = 1 + static_cast<std::uint32_t>(random() % kAllSurfaceFlags);
  if (random() % 4 == 0) return plan;  // only a pose
  plan.vertex_capacity = 1 + static_cast<std::uint32_t>(random() % most);
  plan.triangle_capacity = 1 + static_cast<std::uint32_t>(random() % (2 * most));
  plan.triangles_change = random() % 2 == 0;
  return plan;
}

// Bytes as a publisher would set them up.
std::vector<std::byte> Written(const SurfaceLayout& layout) {
  std::vector<std::byte> bytes(layout.total_bytes);
  SurfaceHeader header;
  header.total_bytes = layout.total_bytes;
  header.memory_generation = 3;
  header.scene_generation = 5;
  header.object_count = static_cast<std::uint32_t>(layout.parts.size());
  std::memcpy(bytes.data(), static_cast<const void*>(&header), sizeof(header));
  for (std::size_t i = 0; i < layout.parts.size(); ++i) {
    const SurfacePart& part = layout.parts[i];
    SurfaceEntry entry;
    SetField(entry.name, part.name);
    entry.object = part.object;
    entry.flags = part.flags;
    entry.vertex_capacity = part.vertex_capacity;
    entry.triangle_capacity = part.triangle_capacity;
    entry.triangle_buffers = part.triangle_buffers;
    entry.vertices = part.vertices;
    entry.triangles = part.triangles;
    std::memcpy(bytes.data() + kSurfaceEntries + i * sizeof(entry), static_cast<const void*>(&entry), sizeof(entry));
  }
  return bytes;
}

// Every buffer within the memory and behind the one before.
void ExpectSound(const SurfaceLayout& layout) {
  std::uint64_t end = kSurfaceEntries + layout.parts.size() * sizeof(SurfaceEntry);
  for (const SurfacePart& part : layout.parts) {
    if (part.vertex_capacity == 0) continue;
    EXPECT_GE(part.vertices, end);
    EXPECT_EQ(part.vertices % 64, 0U);
    end = part.vertices + kSurfaceBuffers * SurfaceBufferBytes(part.vertex_capacity);
    EXPECT_GE(part.triangles, end);
    EXPECT_EQ(part.triangles % 64, 0U);
    end = part.triangles + part.triangle_buffers * SurfaceBufferBytes(part.triangle_capacity);
  }
  EXPECT_LE(end, layout.total_bytes);
}

TEST(SurfaceLayout, AcceptsItsOwnLayouts) {
  std::mt19937_64 random(1);
  for (int round = 0; round < 300; ++round) {
    std::vector<SurfacePlan> plans;
    for (std::uint32_t i = 0; i < random() % 12; ++i) plans.push_back(RandomPlan(random, i, 5000));
    const SurfaceLayout made = LayOutSurfaces(plans);
    ASSERT_EQ(made.problem, "");
    ExpectSound(made);
    const std::vector<std::byte> bytes = Written(made);
    const SurfaceLayout read = CheckSurfaceLayout(bytes.data(), bytes.size());
    ASSERT_EQ(read.problem, "");
    EXPECT_EQ(read.memory_generation, 3U);
    EXPECT_EQ(read.scene_generation, 5U);
    ASSERT_EQ(read.parts.size(), plans.size());
    for (std::size_t i = 0; i < plans.size(); ++i) {
      EXPECT_EQ(read.parts[i].name, plans[i].name);
      EXPECT_EQ(read.parts[i].vertices, made.parts[i].vertices);
      EXPECT_EQ(read.parts[i].triangles, made.parts[i].triangles);
      EXPECT_EQ(read.parts[i].flags, plans[i].flags);
    }
  }
}

TEST(SurfaceLayout, ErrorNamesTheExceededLimit) {
  const auto problem = [](SurfacePlan plan) { return LayOutSurfaces({&plan, 1}).problem; };
  const SurfacePlan good{.name = "a", .flags = kSurfaceSoft, .vertex_capacity = 10, .triangle_capacity = 10};
  EXPECT_EQ(problem(good), "");
  SurfacePlan plan = good;
  plan.flags = 0;
  EXPECT_NE(problem(plan).find("flags 0"), std::string::npos);
  plan = good;
  plan.vertex_capacity = kMaxSurfaceVertices + 1;
  EXPECT_NE(problem(plan).find(std::to_string(kMaxSurfaceVertices)), std::string::npos);
  plan = good;
  plan.triangle_capacity = kMaxSurfaceTriangles + 1;
  EXPECT_NE(problem(plan).find(std::to_string(kMaxSurfaceTriangles)), std::string::npos);
  plan = good;
  plan.triangle_capacity = 0;
  EXPECT_NE(problem(plan).find("without triangles"), std::string::npos);
  plan = good;
  plan.vertex_capacity = kMaxSurfaceVertices;
  plan.triangle_capacity = kMaxSurfaceTriangles;
  plan.triangles_change = true;
  EXPECT_NE(problem(plan).find(std::to_string(kMaxSurfaceBytes)), std::string::npos);
  const std::vector<SurfacePlan> many(kMaxSurfaceObjects + 1, good);
  EXPECT_NE(LayOutSurfaces(many).problem.find("65 objects"), std::string::npos);
}

// Numbers of header and entries are spoiled, each in memory of exactly its size: a sanitizer sees a read beyond it.
TEST(SurfaceLayout, GarbageIsRejectedOrInBounds) {
  std::mt19937_64 random(2);
  std::size_t refused = 0, accepted = 0;
  for (int round = 0; round < 20'000; ++round) {
    std::vector<SurfacePlan> plans;
    for (std::uint32_t i = 0; i < 1 + random() % 3; ++i) plans.push_back(RandomPlan(random, i, 20));
    std::vector<std::byte> bytes = Written(LayOutSurfaces(plans));
    const std::size_t head = kSurfaceEntries + plans.size() * sizeof(SurfaceEntry);
    for (std::size_t k = random() % 5; k > 0; --k) {
      const std::size_t at = random() % (head / 4) * 4;
      const auto value = static_cast<std::uint32_t>(random() >> (random() % 64));
      std::memcpy(bytes.data() + at, &value, sizeof(value));
    }
    if (random() % 4 == 0) bytes.resize(random() % (2 * bytes.size()));
    const std::unique_ptr<std::byte[]> exact(new std::byte[bytes.size()]);
    std::copy(bytes.begin(), bytes.end(), exact.get());
    const SurfaceLayout read = CheckSurfaceLayout(exact.get(), bytes.size());
    (read.problem.empty() ? accepted : refused) += 1;
    if (!read.problem.empty()) continue;
    for (const SurfacePart& part : read.parts) {
      if (part.vertex_capacity == 0) continue;
      ASSERT_LE(part.vertices + kSurfaceBuffers * SurfaceBufferBytes(part.vertex_capacity), bytes.size());
      ASSERT_LE(part.triangles + part.triangle_buffers * SurfaceBufferBytes(part.triangle_capacity), bytes.size());
      ASSERT_EQ(Printable(part.name), part.name);
    }
  }
  EXPECT_GT(refused, 2000U);
  EXPECT_GT(accepted, 2000U);
}

TEST(SurfaceRange, RejectsNonDrawableValues) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<SurfacePoint> points(100, SurfacePoint{0.1f, -0.2f, 100});
  EXPECT_TRUE(InRange(points));
  for (const float bad : {nan, std::numeric_limits<float>::infinity(), -100.1f}) {
    std::vector<SurfacePoint> spoiled = points;
    spoiled[57][1] = bad;
    EXPECT_FALSE(InRange(spoiled)) << bad;
  }
  const std::vector<SurfaceTriangle> triangles{{0, 1, 2}, {2, 1, 3}};
  EXPECT_TRUE(InRange(triangles, 4));
  EXPECT_FALSE(InRange(triangles, 3));
  SurfaceFrame frame;
  EXPECT_TRUE(InRange(frame));
  frame.rotation_wxyz = {0, 0, 0, 0};
  EXPECT_FALSE(InRange(frame));
  frame = {};
  frame.translation_m[2] = static_cast<double>(nan);
  EXPECT_FALSE(InRange(frame));
  frame = {};
  frame.largest_displacement_m = -1;
  EXPECT_FALSE(InRange(frame));
  frame = {};
  frame.vertex_change = ~std::uint64_t{0};
  EXPECT_FALSE(InRange(frame));
}

}  // namespace test_protocol_surface_layout
}  // namespace omni::protocol
