// What a source file says in comments, and the rest of it.
#pragma once

#include <string>
#include <vector>

namespace omni::architecture {

// Comments that follow each other on lines of their own are one.
struct Comment {
  int line = 0;      // where it begins, from 1
  std::string text;  // lines joined by '\n', without "//"
};

struct Source {
  std::string code;  // without comments; strings stay
  std::vector<Comment> comments;
};
// Of C++, C and TypeScript.
Source ReadSource(const std::string& text);

}  // namespace omni::architecture
