// URIs of glTF buffers: embedded data, and names of files beside the document.
#pragma once

#include <string>
#include <vector>

namespace omni::scene {

// "data:...;base64,..." -> bytes. Throws LoadError.
std::vector<unsigned char> DecodeDataUri(const std::string& uri, const std::string& pointer);

// Percent-decoded name of a file in the document's own folder. Throws LoadError on any other place (a scheme, a folder,
// "..", a NUL byte): a scene file must not make the service open files elsewhere.
std::string LocalFileName(const std::string& uri, const std::string& pointer);

}  // namespace omni::scene
