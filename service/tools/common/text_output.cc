#include "service/tools/common/text_output.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iostream>

#include "service/console/wrap.h"

namespace omni::tools {

void Print(const std::string& text) { std::cout << console::ForPeople(text); }

std::string WriteText(const std::string& path, const std::string& text) {
  std::ofstream file(path);
  file << text;
  file.close();
  return file ? std::string() : path + ": cannot be written (" + std::strerror(errno) + "); check the folder";
}

}  // namespace omni::tools
