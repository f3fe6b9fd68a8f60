// Text for people, as wide as their terminal.
#pragma once

#include <string>
#include <vector>

namespace omni::console {

struct TerminalSize {
  int columns = 80;
  int rows = 24;
};

// Of the terminal behind `fd`; 80 x 24 where there is none, or it does not say.
TerminalSize SizeOfTerminal(int fd = 1);

// How wide text on `fd` may be: $COLUMNS, else the terminal's columns; 0: as wide as it is, for `fd` is no terminal and
// what reads it may count on its lines. Never below 20.
int TextColumns(int fd);

std::string Joined(const std::vector<std::string>& words, const std::string& between);

// Breaks lines at spaces so that none is wider than `columns`, but for words that are wider themselves (paths). What
// continues a line stands below its last column of text (two spaces before it make one) that begins in the left half.
// No word is lost, and lines that fit stay as they are. columns <= 0: all of them do.
std::string Wrap(const std::string& text, int columns);

// Wrap for what is about to be written to `fd`.
std::string ForPeople(const std::string& text, int fd = 1);

}  // namespace omni::console
