// Preloaded into hello_xr -g OpenGL: one video mode, for X servers without XFree86-VidModeExtension (Xvfb). hello_xr
// 1.0.20 frees the list that it gets, and ignores that it got none: it ended by a signal in XFree.

#include <cstdlib>

namespace {

// As libXxf86vm has it.
struct ModeInfo {
  unsigned int dot_clock_kHz;
  unsigned short width, sync_start_x, sync_end_x, total_width, skew;
  unsigned short height, sync_start_y, sync_end_y, total_height;
  unsigned int flags;
  int private_size;
  int* private_data;
};

}  // namespace

extern "C" __attribute__((visibility("default"))) int XF86VidModeGetAllModeLines(void*, int, int* count,
                                                                                 ModeInfo*** list) {
  // One block: it is freed as a whole.
  struct ListOfOne {
    ModeInfo* first;
    ModeInfo mode;
  };
  auto* const block = static_cast<ListOfOne*>(std::calloc(1, sizeof(ListOfOne)));
  if (block == nullptr) return 0;
  *list = &block->first;
  ModeInfo& mode = block->mode;
  mode.dot_clock_kHz = 25175;
  mode.width = 640;
  mode.total_width = 800;
  mode.height = 480;
  mode.total_height = 525;
  (*list)[0] = &mode;
  *count = 1;
  return 1;
}
