// What a process that reads foreign files may still do: use the memory that it was granted, read the descriptors that
// it was given, and talk to omnid. Anything else ends it.
#pragma once

#include <cstdint>

#include "service/base/result.h"

namespace omni::builder {

// Before anything foreign is read: no more processor than others leave, the first to go when memory is short, gone with
// the process that started it, no core file. An error names the step that failed.
base::Status Retire();

// Nothing if a sanitizer is built in, which makes calls of its own. From here on every system call but those of
// confine.cc ends this process (SIGSYS): among them any that opens, makes, connects, starts or signals something, or
// that turns memory into code. Cannot be undone.
base::Status ConfineItself();

}  // namespace omni::builder
