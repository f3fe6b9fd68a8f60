// A glTF file read in two steps, so that between them a built scene can be taken from the cache: first the bytes that
// haptics needs, then triangles and materials out of them.
#pragma once

#include <memory>
#include <string>

#include "service/haptics/scene/scene_input.h"
#include "service/scene/build_estimate.h"
#include "service/scene/cache/sha256.h"
#include "service/scene/scene_file.h"

namespace omni::scene {

class SceneReader {
 public:
  // `report` outlives the reader and is filled by both steps.
  SceneReader(std::string path, const LoadOptions& options, LoadReport& report);
  ~SceneReader();

  // How much there is of what is touched, from the JSON and the headers of images. Before ReadBytes() or instead of it.
  // Throws LoadError.
  SceneCounts Count();

  // Reads the JSON and the byte ranges of what is touched. False: nothing is, because the file has no haptic tag; then
  // there is no second step. Throws LoadError.
  bool ReadBytes();

  // Once, after ReadBytes(): of all bytes that were read.
  Digest FinishDigest();

  // Once, after ReadBytes() gave true. Throws LoadError.
  haptics::SceneInput MakeInput();

 private:
  class Loader;
  std::unique_ptr<Loader> loader_;
};

}  // namespace omni::scene
