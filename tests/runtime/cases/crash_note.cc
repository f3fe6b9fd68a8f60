// A crash is put down to whose it is.

#include <signal.h>
#include <stdlib.h>
#include <sys/mman.h>

#include <cstring>
#include <fstream>

#include "tests/runtime/cases/fixture.h"
#include "tests/support/process/temp_folder.h"

namespace omni::runtime {
namespace test_crash_note {

class CrashNote : public RuntimeTest {
 protected:
  void SetUp() override {
    RuntimeTest::SetUp();
    setenv("OMNI_TEST_RUNTIME_CRASH", folder_.Path("crash").c_str(), 1);
  }
  void TearDown() override {
    unsetenv("OMNI_TEST_RUNTIME_CRASH");
    RuntimeTest::TearDown();
  }
  // In a process of its own.
  template <class Crash>
  void ExpectCrash(int signal, Crash crash, const std::string& culprit) {
    EXPECT_EXIT(
        {
          Start();
          crash();
        },
        testing::KilledBySignal(signal), "");
    std::string line;
    std::getline(std::ifstream(folder_.Path("crash")), line);
    EXPECT_EQ(line.substr(line.rfind('/') + 1), culprit);
  }

  omni::test::TempFolder folder_;
};

TEST_F(CrashNote, AbortBelongsToItsCaller) {
  ExpectCrash(
      SIGABRT, [] { std::abort(); }, "test_runtime");
}

TEST_F(CrashNote, JumpToNullIsNowhere) {
  ExpectCrash(
      SIGSEGV,
      [] {
        void (*volatile none)() = nullptr;
        none();
      },
      "nowhere");
}

TEST_F(CrashNote, InstructionsOfNoObjectAreGeneratedCode) {
  ExpectCrash(
      SIGILL,
      [] {
        void* const page = mmap(nullptr, 4096, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        constexpr unsigned char kUndefined[] = {0x0f, 0x0b};
        std::memcpy(page, kUndefined, sizeof(kUndefined));
        reinterpret_cast<void (*)()>(page)();
      },
      "generated code");
}

}  // namespace test_crash_note
}  // namespace omni::runtime
