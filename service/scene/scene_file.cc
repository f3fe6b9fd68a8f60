#include "service/scene/scene_file.h"

#include <new>

#include "service/scene/scene_reader.h"

namespace omni::scene {

base::Result<haptics::SceneInput> LoadSceneFile(const std::string& path, const LoadOptions& options,
                                                LoadReport& report) {
  report = {};
  try {
    SceneReader reader(path, options, report);
    if (reader.ReadBytes()) return reader.MakeInput();
    haptics::SceneInput nothing;
    nothing.name = "untagged";
    return nothing;
  } catch (const std::bad_alloc&) {
    return base::Error{path + ": does not fit into memory; simplify the model"};
  } catch (const std::exception& error) {
    return base::Error{path + ": " + error.what()};
  }
}

}  // namespace omni::scene
