// The system functions that newlib requires: a heap and an exit. Only tests use them; firmware has no heap. No files.
#include <errno.h>
#include <sys/stat.h>

#include <cstddef>

#include "firmware/board/mps2_an500/host_link.h"
#include "firmware/board/mps2_an500/semihosting.h"

extern "C" {

extern char _heap_begin[], _heap_end[];
void* __dso_handle = nullptr;  // the library's destructors at exit, which never comes

void* _sbrk(std::ptrdiff_t bytes) {
  static char* end = _heap_begin;
  if (bytes > _heap_end - end) {
    errno = ENOMEM;
    return reinterpret_cast<void*>(-1);
  }
  char* const before = end;
  end += bytes;
  return before;
}

void _exit(int status) { omni::firmware::board::Exit(status); }
int _getpid() { return 1; }
int _kill(int, int) { omni::firmware::board::Exit(omni::firmware::board::kExitFailuresMax); }

int _open(const char*, int, int) { return -1; }
int _close(int) { return -1; }
int _fstat(int, struct stat*) { return -1; }
int _isatty(int) { return 0; }
int _lseek(int, int, int) { return -1; }
int _read(int, char*, int) { return -1; }
int _write(int, const char*, int) { return -1; }
}
