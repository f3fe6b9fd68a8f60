// What an application shows that draws the models it gets: the file, with its nodes where the state has them, at the
// space's place. A small rasteriser stands for its renderer.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>

#include "layer/src/spaces/pose_math.h"
#include "tests/layer/models/model_app.h"

namespace omni::test {
namespace test_model_picture {

using Point = glm::dvec3;

struct DrawnNode {
  std::string name;
  std::vector<std::array<Point, 3>> triangles;
};

// All nodes with a mesh. The nodes of our file have no transform of their own.
std::vector<DrawnNode> NodesIn(const std::vector<std::uint8_t>& glb) {
  std::uint32_t length = 0;
  std::memcpy(&length, &glb.at(12), sizeof(length));
  const nlohmann::json root = nlohmann::json::parse(glb.begin() + 20, glb.begin() + 20 + length);
  const std::uint8_t* const bytes = glb.data() + 28 + length;
  const auto start = [&](int accessor) {
    return bytes + root["bufferViews"][root["accessors"][accessor]["bufferView"].get<int>()]["byteOffset"].get<int>();
  };
  std::vector<DrawnNode> nodes;
  for (const nlohmann::json& node : root["nodes"]) {
    if (!node.contains("mesh")) continue;
    DrawnNode& drawn = nodes.emplace_back();
    drawn.name = node["name"];
    for (const nlohmann::json& primitive : root["meshes"][node["mesh"].get<int>()]["primitives"]) {
      const int indices = primitive["indices"];
      const auto count = root["accessors"][indices]["count"].get<std::size_t>();
      std::vector<std::uint16_t> index(count);
      std::memcpy(index.data(), start(indices), count * sizeof(std::uint16_t));
      const std::uint8_t* const positions = start(primitive["attributes"]["POSITION"].get<int>());
      for (std::size_t i = 0; i < count; i += 3) {
        std::array<Point, 3>& triangle = drawn.triangles.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
          float p[3];
          std::memcpy(p, positions + index[i + k] * sizeof(p), sizeof(p));
          triangle[k] = {p[0], p[1], p[2]};
        }
      }
    }
  }
  return nodes;
}

constexpr int kWidth = 700, kHeight = 1200;
constexpr double kFocal_px = 2000;

// Camera at the origin, looking along -z.
struct Pixel {
  double x, y;
};
Pixel Project(const Point& p) { return {0.5 * kWidth - kFocal_px * p.x / p.z, 0.5 * kHeight + kFocal_px * p.y / p.z}; }

// Of each pixel, the node that is seen there; empty: none.
struct Picture {
  std::vector<const DrawnNode*> seen = std::vector<const DrawnNode*>(kWidth * kHeight, nullptr);
  std::vector<double> nearness = std::vector<double>(kWidth * kHeight, 0);

  void Draw(const DrawnNode& node, const layer::Pose& X_CN) {
    for (const auto& triangle : node.triangles) {
      std::array<Pixel, 3> at{};
      std::array<double, 3> near{};
      for (std::size_t k = 0; k < 3; ++k) {
        const Point p = X_CN.p + X_CN.q * triangle[k];
        at[k] = Project(p);
        near[k] = -1 / p.z;
      }
      const auto [a, b, c] = at;
      const double area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
      if (area >= 0) continue;  // its back; y points down
      const int bottom = std::min(kHeight - 1, static_cast<int>(std::max({a.y, b.y, c.y})));
      const int right = std::min(kWidth - 1, static_cast<int>(std::max({a.x, b.x, c.x})));
      for (int y = std::max(0, static_cast<int>(std::min({a.y, b.y, c.y}))); y <= bottom; ++y) {
        for (int x = std::max(0, static_cast<int>(std::min({a.x, b.x, c.x}))); x <= right; ++x) {
          const double u = ((x - a.x) * (c.y - a.y) - (c.x - a.x) * (y - a.y)) / area;
          const double v = ((b.x - a.x) * (y - a.y) - (x - a.x) * (b.y - a.y)) / area;
          if (u < 0 || v < 0 || u + v > 1) continue;
          const double depth = near[0] + u * (near[1] - near[0]) + v * (near[2] - near[0]);
          const auto i = static_cast<std::size_t>(y * kWidth + x);
          if (depth <= nearness[i]) continue;
          nearness[i] = depth;
          seen[i] = &node;
        }
      }
    }
  }
  // Pixels of each node, and the lowest of all.
  std::map<std::string, int> Counts() const {
    std::map<std::string, int> counts;
    for (const DrawnNode* node : seen)
      if (node) ++counts[node->name];
    return counts;
  }
  std::string Lowest(Pixel& at) const {
    for (std::size_t i = seen.size(); i-- > 0;) {
      if (!seen[i]) continue;
      const std::size_t column = i % kWidth, row = i / kWidth;
      at = {static_cast<double>(column), static_cast<double>(row)};
      return seen[i]->name;
    }
    return {};
  }
};

// The user's eye, a quarter of a metre before the base and a little below the pen's tip.
const layer::Pose kCamera{{0, -0.30, -0.20}, {1, 0, 0, 0}};

struct Scene {
  FakeService& service;
  ModelApp m;
  XrSpace space = XR_NULL_HANDLE, aim = XR_NULL_HANDLE;
  XrRenderModelEXT pen = XR_NULL_HANDLE;
  std::vector<DrawnNode> nodes;
  std::vector<std::string> moving;

  explicit Scene(FakeService& of) : service(of) {
    if (!m.app.WaitProfile(service, kTouch)) return;
    pen = m.ModelAt("/user/hand/right");
    if (pen == XR_NULL_HANDLE) return;
    const XrRenderModelPropertiesEXT properties = m.PropertiesOf(pen);
    const XrRenderModelAssetEXT asset = m.AssetOf(properties.cacheId);
    nodes = NodesIn(m.BytesOf(asset));
    moving = m.NodesOf(asset, properties.animatableNodeCount);
    space = m.SpaceOf(pen);
    aim = m.app.ActionSpace(m.app.pose, m.app.right);
    service.Fill();
    m.app.Sync();
  }
  layer::Pose InCamera(XrSpace of) const {
    service.Fill();  // a pen without a sample for a tenth of a second is gone
    XrSpaceLocation location{XR_TYPE_SPACE_LOCATION};
    EXPECT_EQ(xrLocateSpace(of, m.local, Now_ns() + kRuntimeOffset_ns, &location), XR_SUCCESS);
    EXPECT_NE(location.locationFlags & XR_SPACE_LOCATION_POSITION_TRACKED_BIT, 0u) << "it would not be drawn";
    return layer::Compose(layer::Inverse(kCamera), layer::FromXr(location.pose));
  }
  Picture Draw() const {
    const layer::Pose X_CM = InCamera(space);
    const auto states = m.StateOf(pen, static_cast<std::uint32_t>(moving.size()));
    Picture picture;
    for (const DrawnNode& node : nodes) {
      layer::Pose X_MN;
      for (std::size_t i = 0; i < moving.size(); ++i)
        if (moving[i] == node.name) X_MN = layer::FromXr(states[i].nodePose);
      picture.Draw(node, layer::Compose(X_CM, X_MN));
    }
    return picture;
  }
};

// Upright, its button towards the user.
FakeService::Trajectory StandingAt(double x_m) {
  return [x_m](protocol::ToolSample& sample) {
    sample.position_base_m = {x_m, 0, 0.06};
    sample.orientation_base_wxyz = {0, 0, 0, 1};
  };
}

TEST(ModelPicture, ShowsThePenWhereItsTipIs) {
  omni_test_reset();
  FakeService service;
  service.SetTrajectory(StandingAt(0));
  const Scene scene(service);
  ASSERT_FALSE(scene.nodes.empty());
  for (const double x_m : {0.0, 0.02, -0.02}) {
    service.SetTrajectory(StandingAt(x_m));
    Pause_ms(60);  // what is predicted is of the new place, too
    const Picture picture = scene.Draw();
    Pixel lowest{};
    EXPECT_EQ(picture.Lowest(lowest), "tip");
    const Pixel tip = Project(scene.InCamera(scene.aim).p);
    EXPECT_NEAR(lowest.x, tip.x, 8) << x_m;
    EXPECT_NEAR(lowest.y, tip.y, 3) << x_m;
    for (const char* part : {"tip", "magnet", "grip", "button"}) EXPECT_GT(picture.Counts()[part], 20) << part;
  }
}

TEST(ModelPicture, ShowsWhatIsPressed) {
  omni_test_reset();
  FakeService service;
  service.SetTrajectory(StandingAt(0));
  const Scene scene(service);
  ASSERT_FALSE(scene.nodes.empty());
  auto rest = scene.Draw().Counts();
  service.Set(protocol::InputIndex::kTipForce, 1);
  auto pressed = scene.Draw().Counts();
  EXPECT_LT(pressed["tip"], 0.6 * rest["tip"]) << "the nib goes in";
  EXPECT_GT(pressed["tip"], 0);
  EXPECT_EQ(pressed["button"], rest["button"]);
  service.Set(protocol::InputIndex::kTipForce, 0);
  service.Set(protocol::InputIndex::kSecondary, 1);
  pressed = scene.Draw().Counts();
  EXPECT_EQ(pressed["tip"], rest["tip"]);
  EXPECT_NE(pressed["button"], rest["button"]);
  EXPECT_GT(pressed["button"], 0);
}

}  // namespace test_model_picture
}  // namespace omni::test
