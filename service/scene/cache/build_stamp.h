// Names the code that made a cached scene: a hash over the sources of service/haptics, service/scene and service/base,
// computed by the build (scripts/cmake/build_stamp.cmake). Other code, other stamp, other cache files.
#pragma once

namespace omni::scene {

extern const char* const kBuildStamp;

}  // namespace omni::scene
