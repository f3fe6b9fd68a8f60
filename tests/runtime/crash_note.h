#pragma once
// Whose crash it is when an application ends by a signal: a driver's, perhaps, which no test of ours can prevent.

namespace omni::runtime {

// With OMNI_TEST_RUNTIME_CRASH=FILE, from now on: one line with the shared object that the process crashed in;
// "generated code" for instructions of none (a driver compiles shaders at run time); "nowhere" for a jump to null. The
// process then ends by the signal as it would have.
void NoteCrashes();

}  // namespace omni::runtime
