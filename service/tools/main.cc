#include "service/tools/common/command_line.h"

int main(int argc, char** argv) { return omni::tools::RunCommandLine(argc, argv); }
