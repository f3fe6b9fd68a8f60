// Documents designed to cost a reader as much as possible, each with about the given number of bytes.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace omni::test {

struct Bomb {
  const char* name;
  std::string (*make)(std::size_t bytes);
};

namespace bombs {

inline std::string Gltf(const std::string& content) { return R"({"asset":{"version":"2.0"},)" + content + "}"; }

// "element,element,...", # in it for the number of each: `count` of them.
inline std::string List(std::string_view element, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) text += ',';
    for (const char c : element) text += c == '#' ? std::to_string(i) : std::string(1, c);
  }
  return text;
}

// The same, about `bytes` long.
inline std::string Filled(std::string_view element, std::size_t bytes) {
  const std::size_t number = element.find('#') == element.npos ? 0 : 4;
  return List(element, std::max<std::size_t>(1, bytes / (element.size() + 1 + number)));
}

// As many nodes as fit, all in the scene, and `rest`.
inline std::string Nodes(std::string_view node, std::size_t bytes, const std::string& rest) {
  const std::size_t count = std::clamp<std::size_t>(bytes / (node.size() + 7), 1, 100'000);
  return Gltf(R"("scene":0,"scenes":[{"nodes":[)" + List("#", count) + R"(]}],"nodes":[)" + List(node, count) + "]," +
              rest);
}

inline std::string OneNode(const std::string& rest) { return Nodes(R"({"mesh":0,"extras":{"haptic":1}})", 1, rest); }

inline std::string Mesh(const std::string& primitives) { return R"("meshes":[{"primitives":[)" + primitives + "]}]"; }

// Buffer 0 is `bytes` bytes of zeros, with a view of all of them.
inline std::string ZeroBuffer(std::size_t bytes) {
  const std::string length = std::to_string(bytes);
  return R"("buffers":[{"byteLength":)" + length + R"(,"uri":"data:;base64,)" + std::string(bytes / 3 * 4 + 4, 'A') +
         R"("}],"bufferViews":[{"buffer":0,"byteLength":)" + length + "}],";
}

// Accessor 0 has the corners of a triangle over the base.
constexpr const char* kTriangle =
    R"("buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAM3MTD0AAAAACtcjPM3MTD0AAAAAAAAAAM3MTD0K1yM8"}],)"
    R"("bufferViews":[{"buffer":0,"byteLength":36}],)"
    R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],)";

inline std::string NestedObjects(std::size_t n) {
  std::string text;
  while (text.size() < n) text += "{\"a\":";
  return Gltf("\"x\":" + text);
}

inline std::string Escapes(std::size_t n) {
  std::string text;
  while (text.size() < n) text += "\\u00e9";
  return Gltf("\"x\":\"" + text + "\"");
}

inline std::string CutBuffer(std::size_t n) {
  return OneNode(R"("buffers":[{"byteLength":1000000000,"uri":"data:;base64,)" + std::string(n, 'A') +
                 R"("}],"bufferViews":[{"buffer":0,"byteLength":900000000}],)"
                 R"("accessors":[{"bufferView":0,"componentType":5126,"count":75000000,"type":"VEC3"}],)" +
                 Mesh(R"({"attributes":{"POSITION":0}})"));
}

inline std::string Draco(std::size_t n) {
  return OneNode(
      R"("extensionsRequired":[)" + Filled("\"KHR_xmp\"", n / 2) + "]," + kTriangle +
      Mesh(Filled(R"({"attributes":{"POSITION":0},"extensions":{"KHR_draco_mesh_compression":{}}})", n / 2)));
}

// Each node shows the triangle in a shape of its own, by one of as many weights as fit.
inline std::string Shapes(std::size_t n) {
  return Nodes(R"({"mesh":0,"weights":[0.#],"extras":{"haptic":1}})", n / 2,
               std::string(kTriangle) + R"("meshes":[{"weights":[)" + Filled("0", n / 4) +
                   R"(],"primitives":[{"attributes":{"POSITION":0},"targets":[)" + Filled(R"({"POSITION":0})", n / 4) +
                   "]}]}]");
}

// A mesh whose vertices as many targets move as may have a weight.
inline std::string Targets(std::size_t n) {
  const std::size_t vertices = n / 6;
  return OneNode(ZeroBuffer(3 * vertices) + R"("accessors":[{"bufferView":0,"componentType":5121,"count":)" +
                 std::to_string(vertices) + R"(,"type":"VEC3"}],"meshes":[{"weights":[)" + List("1", 64) +
                 R"(],"primitives":[{"attributes":{"POSITION":0},"targets":[)" + List(R"({"POSITION":0})", 64) +
                 "]}]}]");
}

// One skin of as many joints as fit, at as many nodes.
inline std::string Joints(std::size_t n) {
  const std::string corners =
      R"("buffers":[{"byteLength":84,"uri":"data:;base64,AAAAAM3MTD0AAAAACtcjPM3MTD0AAAAAAAAAAM3MTD0K1yM8)" +
      std::string(64, 'A') +
      R"("}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,)"
      R"("byteLength":48}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},)"
      R"({"bufferView":1,"componentType":5121,"count":3,"type":"VEC4"},)"
      R"({"bufferView":1,"componentType":5126,"count":3,"type":"VEC4"}],)";
  return Nodes(R"({"mesh":0,"skin":0,"extras":{"haptic":1}})", n / 2,
               corners + R"("skins":[{"joints":[)" + Filled("0", n / 2) + "]}]," +
                   Mesh(R"({"attributes":{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2}})"));
}

// Primitives that share one stream, which is none; and views that say what they are decoded to.
inline std::string Streams(std::size_t n) {
  return OneNode(R"("extensionsRequired":["KHR_draco_mesh_compression"],)" + std::string(kTriangle) +
                 Mesh(Filled(R"({"attributes":{"POSITION":0},"indices":0,"extensions":{"KHR_draco_mesh_compression":)"
                             R"({"bufferView":0,"attributes":{"POSITION":0}}}})",
                             n)));
}

inline std::string CompressedViews(std::size_t n) {
  return OneNode(
      R"("buffers":[{"byteLength":36,"uri":"data:;base64,oAAAAM3MTD0AAAAACtcjPM3MTD0AAAAAAAAAAM3MTD0K1yM8"},)"
      R"({"byteLength":4096}],"bufferViews":[)" +
      Filled(R"({"buffer":1,"byteLength":4096,"extensions":{"EXT_meshopt_compression":{"buffer":0,"byteLength":36,)"
             R"("byteStride":256,"count":4000000,"mode":"ATTRIBUTES"}}})",
             n) +
      R"(],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],)" +
      Mesh(R"({"attributes":{"POSITION":0}})"));
}

inline std::string TextureEntries(std::size_t n) {
  return Nodes(R"({"mesh":0})", 1,
               R"("extensions":{"MPEG_haptic_material":{"materials":[{"stiffness":[)" + Filled("{}", n) +
                   R"(]}]}},"meshes":[{"extensions":{"MPEG_haptic_material":{"hapticMaterialIndex":0}},)"
                   R"("primitives":[{"attributes":{}}]}])");
}

inline std::string SharedVertices(std::size_t n) {
  const std::size_t vertices = n / 8;
  const std::string accessor = R"(,"componentType":5121,"count":)" + std::to_string(vertices) + R"(,"type":"VEC3"},)";
  return OneNode(
      ZeroBuffer(3 * vertices + 4) + R"("accessors":[{"bufferView":0)" + accessor +
      R"({"bufferView":0,"byteOffset":4)" + accessor +
      R"({"bufferView":0,"componentType":5121,"count":3,"type":"SCALAR"}],)" +
      Mesh(Filled(R"({"attributes":{"POSITION":0},"indices":2},{"attributes":{"POSITION":1},"indices":2})", n / 2)));
}

inline std::string OverlappingAccessors(std::size_t n) {
  const std::size_t vertices = n / 8, accessors = n / 400;
  const std::string position = R"({"bufferView":0,"byteOffset":#,"componentType":5121,"count":)" +
                               std::to_string(vertices) + R"(,"type":"VEC3"})";
  const std::string indices = std::to_string(accessors);
  return OneNode(ZeroBuffer(3 * vertices + accessors) + R"("accessors":[)" + List(position, accessors) +
                 R"(,{"bufferView":0,"componentType":5121,"count":3,"type":"SCALAR"}],)" +
                 Mesh(List(R"({"attributes":{"POSITION":#},"indices":)" + indices + "}", accessors)));
}

inline std::string OverlappingImages(std::size_t n) {
  return Nodes(R"({"mesh":#,"extras":{"haptic":1}})", n / 6,
               ZeroBuffer(n / 4) +
                   R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],)"
                   R"("extensions":{"MPEG_haptic_material":{"materials":[)" +
                   Filled(R"({"stiffness":[{"texture":{"index":#}}]})", n / 3) + R"(]}},"textures":[)" +
                   Filled(R"({"source":#})", n / 6) + R"(],"images":[)" + Filled(R"({"bufferView":0})", n / 5) +
                   R"(],"meshes":[)" +
                   Filled(R"({"extensions":{"MPEG_haptic_material":{"hapticMaterialIndex":#}},)"
                          R"("primitives":[{"attributes":{"POSITION":0}}]})",
                          n / 2) +
                   "]");
}

// A typical legitimate document: many nodes that show one of a few meshes, with names, transforms and a program's own
// extras.
inline std::string HonestNodes(std::size_t count = 100'000) {
  const char* node = R"({"name":"part #","translation":[0.001,0,0],"rotation":[0,0,0,1],"scale":[1,1,1],)"
                     R"("extras":{"maker":"somebody","layer":#}})";
  return Gltf(R"("scene":0,"scenes":[{"nodes":[)" + List("#", count) + R"(]}],"nodes":[)" + List(node, count - 1) +
              R"(,{"mesh":0,"extras":{"haptic":{"stiffness":300}}}],)" + kTriangle +
              Mesh(R"({"attributes":{"POSITION":0}})"));
}

}  // namespace bombs

// Each was or could be slow or large, or end the process.
inline const std::array kSceneBombs = {
    Bomb{"empty objects", [](std::size_t n) { return bombs::Gltf("\"x\":[" + bombs::Filled("{}", n) + "]"); }},
    Bomb{"empty arrays", [](std::size_t n) { return bombs::Gltf("\"x\":[" + bombs::Filled("[]", n) + "]"); }},
    Bomb{"empty texts", [](std::size_t n) { return bombs::Gltf("\"x\":[" + bombs::Filled("\"\"", n) + "]"); }},
    Bomb{"numbers", [](std::size_t n) { return bombs::Gltf("\"x\":[" + bombs::Filled("1", n) + "]"); }},
    Bomb{"objects of one key",
         [](std::size_t n) { return bombs::Gltf("\"x\":[" + bombs::Filled("{\"a\":{}}", n) + "]"); }},
    Bomb{"nested arrays", [](std::size_t n) { return bombs::Gltf("\"x\":" + std::string(n, '[')); }},
    Bomb{"nested objects", bombs::NestedObjects},
    Bomb{"different keys", [](std::size_t n) { return bombs::Gltf(bombs::Filled("\"#\":0", n)); }},
    Bomb{"the same key", [](std::size_t n) { return bombs::Gltf(bombs::Filled("\"a\":0", n)); }},
    Bomb{"number of many digits", [](std::size_t n) { return bombs::Gltf("\"x\":" + std::string(n, '9')); }},
    Bomb{"long fraction", [](std::size_t n) { return bombs::Gltf("\"x\":0." + std::string(n, '9')); }},
    Bomb{"long exponent", [](std::size_t n) { return bombs::Gltf("\"x\":1e" + std::string(n, '9')); }},
    Bomb{"long text", [](std::size_t n) { return bombs::Gltf("\"x\":\"" + std::string(n, 'x') + "\""); }},
    Bomb{"text without end", [](std::size_t n) { return bombs::Gltf("\"x\":\"" + std::string(n, 'x')); }},
    Bomb{"text of escapes", bombs::Escapes},
    Bomb{"text that is not UTF-8",
         [](std::size_t n) { return bombs::Gltf("\"x\":\"" + std::string(n, 'x') + "\xFF\""); }},
    Bomb{"blanks", [](std::size_t n) { return bombs::Gltf("\"x\":" + std::string(n, ' ') + "0"); }},
    Bomb{"base64 that is cut off", bombs::CutBuffer},
    Bomb{"nodes x primitives",
         [](std::size_t n) { return bombs::Nodes(R"({"mesh":0})", n / 2, bombs::Mesh(bombs::Filled("{}", n / 2))); }},
    Bomb{"tagged nodes x primitives",
         [](std::size_t n) {
           return bombs::Nodes(R"({"mesh":0,"extras":{"haptic":1}})", n / 2, bombs::Mesh(bombs::Filled("{}", n / 2)));
         }},
    Bomb{"tagged nodes", [](std::size_t n) { return bombs::Nodes(R"({"extras":{"haptic":1}})", n, "\"x\":0"); }},
    Bomb{"tags of bad text", [](std::size_t n) { return bombs::Nodes(R"({"extras":{"haptic":"{"}})", n, "\"x\":0"); }},
    Bomb{"different materials",
         [](std::size_t n) {
           return bombs::Nodes(R"({"mesh":0,"extras":{"haptic":{"popThrough":0.#}}})", n,
                               bombs::kTriangle + bombs::Mesh(R"({"attributes":{"POSITION":0}})"));
         }},
    Bomb{"keys of a tag",
         [](std::size_t n) {
           return bombs::Gltf(R"("nodes":[{"extras":{"haptic":{)" + bombs::Filled("\"#\":{}", n) + "}}}]");
         }},
    Bomb{"required extensions x Draco primitives", bombs::Draco},
    Bomb{"nodes x weights of targets", bombs::Shapes},
    Bomb{"vertices x targets", bombs::Targets},
    Bomb{"nodes x joints", bombs::Joints},
    Bomb{"primitives of one stream", bombs::Streams},
    Bomb{"views that say they are large", bombs::CompressedViews},
    Bomb{"entries of a texture", bombs::TextureEntries},
    Bomb{"primitives that share vertices", bombs::SharedVertices},
    Bomb{"overlapping accessors", bombs::OverlappingAccessors},
    Bomb{"overlapping images", bombs::OverlappingImages},
    Bomb{"vertices without data",
         [](std::size_t) {
           return bombs::OneNode(R"("accessors":[{"componentType":5126,"count":11999997,"type":"VEC3"}],)" +
                                 bombs::Mesh(R"({"attributes":{"POSITION":0}})"));
         }},
};

}  // namespace omni::test
