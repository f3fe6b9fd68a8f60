// Why a file was refused. Thrown inside this module only; LoadSceneFile turns it into base::Error.
#pragma once

#include <stdexcept>
#include <string>

namespace omni::scene {

// A message may quote a file's own words, and goes to terminals and logs: no control characters, and a bounded length.
std::string Printable(std::string message);

class LoadError : public std::runtime_error {
 public:
  // `pointer`: JSON pointer of the culprit ("" = the file as a whole); `what`: what is wrong, the limit, what to do.
  LoadError(const std::string& pointer, const std::string& what)
      : std::runtime_error(Printable(pointer.empty() ? what : pointer + ": " + what)) {}
};

}  // namespace omni::scene
